"""Near miss: how close the body came to an obstacle and to the evader. Teammates: see `separation`."""

from __future__ import annotations

import numpy as np

from flightapp.analysis import motion
from flightapp.analysis.analysers.analyser import MISSION, PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.metrics import airborne
from flightapp.sim.world import World

NAME = "near miss"


def examine(subject: Subject) -> list[Finding]:
    return [*_known_on_board(subject), *_surveyed(subject), *_evader(subject)] or [
        Finding(NAME, Severity.OK, "no obstacle came near", "No obstacle was known, and no evader.", vehicle=subject.name)
    ]


def _known_on_board(subject: Subject) -> list[Finding]:
    """By the discs that the vehicle itself saw."""
    setpoints = subject.topic("/setpoint")
    clearance = setpoints.column("clearance_m")
    if not np.isfinite(clearance).any():
        return []
    nearest = int(np.nanargmin(clearance))
    return [_obstacle(subject, float(clearance[nearest]), float(setpoints.t_s[nearest]), "as seen on board")]


def _surveyed(subject: Subject) -> list[Finding]:
    """By the mission's obstacles: the whole truth in a simulation, what was surveyed in the field."""
    obstacles, track, window = subject.mission.obstacles, subject.vehicle.track, subject.airborne
    if track is None or window is None or not (obstacles.cylinders or obstacles.boxes):
        return []
    nearest = motion.nearest_obstacle(track.within(window), World(obstacles), subject.profile.limits.body_radius_m)
    return [] if nearest is None else [_obstacle(subject, *nearest, "as surveyed")]


def _obstacle(subject: Subject, clearance_m: float, t_s: float, source: str) -> Finding:
    """Limits: contact; what the guards brake for; what the planner keeps. Each is the profile's own."""
    guarded_m, planned_m = subject.profile.safety.obstacle_clearance_min_m, subject.profile.limits.safety_margin_m
    severity, title = Severity.OK, "clear of obstacles"
    if clearance_m < 0.0:
        severity, title = Severity.FAILURE, "contact with an obstacle"
    elif clearance_m < guarded_m:
        severity, title = Severity.WARNING, "near miss of an obstacle"
    elif clearance_m < planned_m:
        severity, title = Severity.NOTE, "inside the planner's margin"
    text = (
        f"The body came within {clearance_m:.2f} m of an obstacle, {source}; "
        f"the guards keep {guarded_m:g} m and the planner {planned_m:g} m."
    )
    evidence: dict[str, float | str] = {
        "clearance_m": clearance_m,
        "guarded_m": guarded_m,
        "planned_m": planned_m,
        "source": source,
    }
    return Finding(NAME, severity, title, text, t_s, t_s, evidence, subject.name)


def _evader(subject: Subject) -> list[Finding]:
    """Only where the evader's own or true states are known: an estimate cannot tell how wrong it was."""
    evaders = subject.run.with_role("evader")
    if not subject.is_pursuer or not evaders or evaders[0].track is None or subject.vehicle.track is None:
        return []
    theirs = airborne(evaders[0])
    window = None if theirs is None or subject.airborne is None else subject.airborne.common(theirs)
    nearest = None if window is None else motion.min_distance_m(subject.vehicle.track, evaders[0].track, window)
    if nearest is None:
        return []
    distance_m, t_s = nearest
    keep_out_m = 0.0 if subject.mission.target_contact_allowed else subject.profile.safety.target_keep_out_m
    touching_m = 0.0 if subject.mission.target_contact_allowed else 2 * subject.profile.limits.body_radius_m
    severity, title = Severity.OK, "clear of the evader"
    if distance_m < touching_m:
        severity, title = Severity.FAILURE, "contact with the evader"
    elif distance_m < keep_out_m:
        severity, title = Severity.WARNING, "inside the evader's keep-out"
    text = f"The centres of {subject.name} and the evader came within {distance_m:.2f} m; {keep_out_m:g} m must be kept."
    evidence: dict[str, float | str] = {"distance_m": distance_m, "keep_out_m": keep_out_m, "other": evaders[0].name}
    return [Finding(NAME, severity, title, text, t_s, t_s, evidence, subject.name)]


ANALYSER = Analyser(
    NAME, "How close did it come to obstacles and to the evader?", ("/own", "/setpoint", MISSION, PROFILE), examine
)
