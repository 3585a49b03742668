"""Separation: the distance of each two pursuers in the air, also where the other one's recording is missing."""

from __future__ import annotations

import numpy as np

from flightapp.analysis import motion
from flightapp.analysis.analysers.analyser import MISSION, PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.metrics import airborne
from flightapp.analysis.run import VehicleRun

NAME = "separation"


def examine(subject: Subject) -> list[Finding]:
    """Each pair once: by the vehicle that comes first, or by the only one whose recording there is."""
    recorded = {vehicle.name: vehicle for vehicle in subject.run.with_role("pursuer")}
    names = [vehicle.name for vehicle in subject.mission.vehicles if vehicle.role == "pursuer" and vehicle.name != subject.name]
    found = []
    for name in names:
        if name not in recorded:
            found.append(_as_heard(subject, name))
        elif list(recorded).index(subject.name) < list(recorded).index(name):
            found.append(_of_tracks(subject, recorded[name]))
    return [finding for finding in found if finding is not None]


def _of_tracks(subject: Subject, other: VehicleRun) -> Finding | None:
    theirs = airborne(other)
    window = None if subject.airborne is None or theirs is None else subject.airborne.common(theirs)
    if window is None or subject.vehicle.track is None or other.track is None:
        return None
    nearest = motion.min_distance_m(subject.vehicle.track, other.track, window)
    return None if nearest is None else _finding(subject, other.name, *nearest, f"by the states of both ({other.track.source})")


def _as_heard(subject: Subject, name: str) -> Finding | None:
    heard, track = subject.heard.get(name), subject.vehicle.track
    if heard is None or track is None or subject.airborne is None:
        return None
    then_s = heard.t_s - heard.age_s
    inside = (then_s >= max(subject.airborne.start_s, track.t_s[0])) & (then_s <= min(subject.airborne.end_s, track.t_s[-1]))
    inside &= heard.is_done == 0
    if not inside.any():
        return None
    distances = np.linalg.norm(track.at(then_s[inside]).position_ned_m - heard.position_ned_m[inside], axis=1)
    nearest = int(np.argmin(distances))
    source = f"by what {subject.name} heard of it: its own recording is missing"
    return _finding(subject, name, float(distances[nearest]), float(then_s[inside][nearest]), source)


def _finding(subject: Subject, other: str, distance_m: float, t_s: float, source: str) -> Finding:
    """The profile's own limit, and the buffer that the guards keep on top of it."""
    safety = subject.profile.safety
    required_m = safety.separation_min_m
    severity, title = Severity.OK, "separation kept"
    if distance_m < required_m:
        severity, title = Severity.FAILURE, "separation lost"
    elif distance_m < required_m + 0.5 * safety.separation_buffer_m:
        # The buffer is there to be leant on; half of it gone is more than drift and estimation error explain.
        severity, title = Severity.WARNING, "separation nearly lost"
    text = f"{subject.name} and {other} came within {distance_m:.2f} m, {source}; {required_m:g} m are required."
    evidence: dict[str, float | str] = {"distance_m": distance_m, "required_m": required_m, "other": other}
    return Finding(NAME, severity, title, text, t_s, t_s, evidence, subject.name)


def _concerns(subject: Subject) -> bool:
    return subject.is_pursuer


ANALYSER = Analyser(NAME, "Did the pursuers keep apart?", ("/own", "/team", MISSION, PROFILE), examine, _concerns)
