"""The figures of one vehicle and of the fleet. What is not recorded is None: nothing is made up.

Windows: the *pursuit* is the phase `pursue`; *offboard* is pursue to return; *airborne* is takeoff to land, and where true
states are known only while the vehicle is not on the ground.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from flightapp.analysis import motion, timing
from flightapp.analysis.outcome import captured_s, pursuers_of
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.track import Track
from flightapp.recording.phases import AIRBORNE, OFFBOARD, Window
from flightapp.sim.world import World

Figures = dict[str, Any]


def airborne(vehicle: VehicleRun) -> Window | None:
    """When the vehicle flew."""
    window = vehicle.phases.window(AIRBORNE)
    if vehicle.flown is None:
        return window
    return vehicle.flown if window is None else vehicle.flown.common(window)


def vehicle_figures(vehicle: VehicleRun, world: World | None) -> Figures:
    """The vehicle's own section of the summary. `world`: the true world, None where it is unknown."""
    recording = vehicle.recording
    pursuit, offboard = vehicle.phases.window(("pursue",)), vehicle.phases.window(OFFBOARD)
    pursued = _part(vehicle.track, pursuit)
    setpoints = timing.within(recording.topic("/setpoint"), offboard)
    gap = timing.setpoint_gap_ms(setpoints)
    decisions = timing.within(recording.topic("/decision"), offboard)
    latencies = timing.decision_latency_ms(decisions)
    events = recording.topic("/event").texts("level")
    return {
        "role": vehicle.role,
        "outcome": vehicle.phases.outcome,
        "track_source": None if vehicle.track is None else vehicle.track.source,
        "path_length_m": None if pursued is None else motion.path_length_m(pursued),
        "mean_jerk_m_s3": None if pursued is None else motion.mean_jerk_m_s3(pursued),
        "speed_max_m_s": None if pursued is None else float(np.linalg.norm(pursued.velocity_ned_m_s, axis=1).max()),
        "min_obstacle_clearance_m": _clearance_m(vehicle, world),
        "decision_latency_ms": {stage: timing.spread(values) for stage, values in latencies.items()},
        "perception_latency_ms": timing.spread(
            timing.perception_latency_ms(timing.within(recording.topic("/obstacles"), offboard))
        ),
        "frame_to_setpoint_ms": timing.spread(timing.frame_to_setpoint_ms(setpoints)),
        "setpoint_rate_hz": timing.setpoint_rate_hz(setpoints),
        "setpoint_gap_p50_ms": gap["p50"],
        "setpoint_gap_p99_ms": gap["p99"],
        "setpoint_gap_max_ms": gap["p100"],
        "cpu_fraction": timing.mean_and_max(recording.topic("/health").column("cpu_fraction")),
        "memory_mb": timing.mean_and_max(recording.topic("/health").column("memory_mb")),
        "dropped": timing.dropped(recording),
        "modes": timing.share(timing.within(recording.topic("/decision"), pursuit).texts("mode")),
        "events": {level: events.count(level) for level in ("info", "warning", "error")},
        "recording_complete": recording.complete,
    }


def fleet_latencies(run: Run) -> Figures:
    """Latencies of all pursuers together."""
    decisions: dict[str, list[Any]] = {stage: [] for stage in timing.STAGES}
    perception = []
    frames = []
    for vehicle in pursuers_of(run):
        offboard = vehicle.phases.window(OFFBOARD)
        series = {topic: timing.within(vehicle.recording.topic(topic), offboard) for topic in _LATENCY_TOPICS}
        for stage, values in timing.decision_latency_ms(series["/decision"]).items():
            decisions[stage].append(values)
        perception.append(timing.perception_latency_ms(series["/obstacles"]))
        frames.append(timing.frame_to_setpoint_ms(series["/setpoint"]))
    none = [np.zeros(0)]
    return {
        "decision_latency_ms": {stage: timing.spread(np.concatenate(parts or none)) for stage, parts in decisions.items()},
        "perception_latency_ms": timing.spread(np.concatenate(perception or none)),
        "frame_to_setpoint_ms": timing.spread(np.concatenate(frames or none)),
    }


_LATENCY_TOPICS = ("/decision", "/obstacles", "/setpoint")


def min_separation_m(run: Run) -> float | None:
    """Smallest distance between the centres of two pursuers while both fly; None with fewer than two known."""
    found = []
    for first, second in itertools.combinations(pursuers_of(run), 2):
        windows = airborne(first), airborne(second)
        if first.track is None or second.track is None or windows[0] is None or windows[1] is None:
            continue
        common = windows[0].common(windows[1])
        nearest = None if common is None else motion.min_distance_m(first.track, second.track, common)
        if nearest is not None:
            found.append(nearest[0])
    return min(found, default=None)


def min_target_distance_m(run: Run) -> float | None:
    """Smallest distance between the centres of the evader and a pursuer during the pursuit."""
    evader = run.evader_track()
    found = []
    for vehicle in pursuers_of(run):
        window = vehicle.phases.window(("pursue",))
        if evader is None or vehicle.track is None or window is None or vehicle.role == "evader":
            continue
        nearest = motion.min_distance_m(vehicle.track, evader, window)
        if nearest is not None:
            found.append(nearest[0])
    return min(found, default=None)


def boundary_figures(run: Run) -> Figures:
    """The evader's distance to the protected boundary: smallest during the pursuit, and when it was captured."""
    figures: Figures = {"boundary_distance_m": None, "boundary_distance_at_capture_m": None, "evader_track_source": None}
    evader = run.evader_track()
    windows = [window for vehicle in pursuers_of(run) if (window := vehicle.phases.window(("pursue",))) is not None]
    if run.mission is None or evader is None or not windows:
        return figures
    figures["evader_track_source"] = evader.source
    boundary = run.mission.boundary.as_boundary()
    pursued = evader.within(Window(min(w.start_s for w in windows), max(w.end_s for w in windows)))
    if len(pursued):
        figures["boundary_distance_m"] = float(motion.boundary_distances_m(pursued.position_ned_m, boundary).min())
    when_s = captured_s(run)
    if when_s is not None and evader.t_s[0] <= when_s <= evader.t_s[-1]:
        at_capture = evader.at(np.array([when_s])).position_ned_m
        figures["boundary_distance_at_capture_m"] = float(motion.boundary_distances_m(at_capture, boundary)[0])
    return figures


def _part(track: Track | None, window: Window | None) -> Track | None:
    """The part of a track inside a window; None if there is none."""
    if track is None or window is None:
        return None
    part = track.within(window)
    return part if len(part) >= 2 else None


def _clearance_m(vehicle: VehicleRun, world: World | None) -> float | None:
    flown = _part(vehicle.track, airborne(vehicle))
    if flown is None or world is None or vehicle.profile is None:
        return None
    return motion.min_clearance_m(flown, world, vehicle.profile.limits.body_radius_m)
