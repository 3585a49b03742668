"""What of a run is shown and exported over time: every quantity of every vehicle as one named series with its unit."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flightapp.analysis import motion, timing
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.outcome import pursuers_of
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.track import Track
from flightapp.core.types import Array
from flightapp.sim.world import World

OUT_OF_SIGHT_M = 60.0
"""A clearance beyond it is that of a world without obstacles."""


@dataclass(frozen=True, slots=True)
class Signal:
    """One quantity of one vehicle. `quantity` with `unit` names its column; `detail` tells apart several of one chart."""

    quantity: str
    unit: str
    vehicle: str
    t_s: Array  # (n,) fleet time
    values: Array  # (n,) NaN where not known
    detail: str = ""

    @property
    def column(self) -> str:
        """For a table: vehicle, quantity, detail, unit last."""
        words = [self.quantity, *self.detail.split(), *([self.unit] if self.unit else [])]
        return f"{self.vehicle}.{'_'.join(words)}"

    @property
    def label(self) -> str:
        """For a legend."""
        return f"{self.vehicle}, {self.detail}" if self.detail else self.vehicle


def signals_of(run: Run) -> list[Signal]:
    """All that the recordings tell, in the order of the report."""
    world = _world(run)
    found = [signal for vehicle in run.vehicles for signal in _of_vehicle(run, vehicle, world)]
    return [*_separations(run), *(signal for signal in found if len(signal.t_s) and np.isfinite(signal.values).any())]


def _of_vehicle(run: Run, vehicle: VehicleRun, world: World | None) -> Iterator[Signal]:
    yield from _motion(run, vehicle)
    yield from _clearances(vehicle, world)
    yield from _target(run, vehicle)
    yield from _setpoints(vehicle)
    yield from _perception(vehicle)
    yield from _links(run, vehicle)
    yield from _health(vehicle)


def _motion(run: Run, vehicle: VehicleRun) -> Iterator[Signal]:
    track, name = vehicle.track, vehicle.name
    if track is None:
        return
    evader = run.evader_track()
    if evader is not None and vehicle in pursuers_of(run) and vehicle.role != "evader":
        inside = (track.t_s >= evader.t_s[0]) & (track.t_s <= evader.t_s[-1])
        gap = track.position_ned_m[inside] - evader.at(track.t_s[inside]).position_ned_m
        yield Signal("distance_to_evader", "m", name, track.t_s[inside], np.linalg.norm(gap, axis=1))
    yield Signal("speed", "m_s", name, track.t_s, np.linalg.norm(track.velocity_ned_m_s[:, :2], axis=1))
    yield Signal("height", "m", name, track.t_s, -track.position_ned_m[:, 2])
    jerk_t_s, jerk = motion.jerk_m_s3(track)
    yield Signal("jerk", "m_s3", name, jerk_t_s, jerk)


def _separations(run: Run) -> Iterator[Signal]:
    """Of every two pursuers."""
    for first, second in itertools.combinations(pursuers_of(run), 2):
        if first.track is None or second.track is None or "evader" in (first.role, second.role):
            continue
        start_s, end_s = max(first.track.t_s[0], second.track.t_s[0]), min(first.track.t_s[-1], second.track.t_s[-1])
        t_s = first.track.t_s[(first.track.t_s >= start_s) & (first.track.t_s <= end_s)]
        gap = first.track.at(t_s).position_ned_m - second.track.at(t_s).position_ned_m
        if len(t_s):
            yield Signal("separation", "m", first.name, t_s, np.linalg.norm(gap, axis=1), f"to {second.name}")


def _clearances(vehicle: VehicleRun, world: World | None) -> Iterator[Signal]:
    """Of the body to the surveyed world, and to the discs known on board."""
    if world is not None and vehicle.track is not None and vehicle.profile is not None and vehicle.role != "evader":
        distances = np.array([world.signed_distance_m(*point) for point in vehicle.track.position_ned_m.tolist()])
        clearance = distances - vehicle.profile.limits.body_radius_m
        yield Signal("clearance", "m", vehicle.name, vehicle.track.t_s, clearance, "surveyed")
    setpoints = vehicle.recording.topic("/setpoint")
    known = setpoints.column("clearance_m")
    known[known > OUT_OF_SIGHT_M] = np.nan
    yield Signal("clearance", "m", vehicle.name, setpoints.t_s, known, "known on board")


def _target(run: Run, vehicle: VehicleRun) -> Iterator[Signal]:
    """Error of the estimate where the evader's way is known by more than estimates, and what the estimate itself admits."""
    series = vehicle.recording.topic("/target")
    t_s = series.column("t_s")
    true = true_evader(run)
    if true is not None and len(series):
        inside = (t_s >= true.t_s[0]) & (t_s <= true.t_s[-1])
        gap = series.vectors("position_ned_m")[inside] - true.at(t_s[inside]).position_ned_m
        yield Signal("target_error", "m", vehicle.name, series.t_s[inside], np.linalg.norm(gap[:, :2], axis=1))
    yield Signal("target_error", "m", vehicle.name, series.t_s, 2.0 * series.column("position_sigma_m"), "2 sigma")
    yield Signal("target_age", "s", vehicle.name, series.t_s, series.column("age_s"))


def true_evader(run: Run) -> Track | None:
    """The evader's way by the simulation or by itself; None where only estimates of it are known."""
    track = run.evader_track()
    return None if track is None or track.source == "estimate" else track


def _setpoints(vehicle: VehicleRun) -> Iterator[Signal]:
    decisions, setpoints = vehicle.recording.topic("/decision"), vehicle.recording.topic("/setpoint")
    yield Signal("planner_latency", "ms", vehicle.name, decisions.t_s, decisions.column("latency_s") * 1e3)
    new = setpoints.column("new_frame") == 1.0
    latency = (setpoints.column("t_s") - setpoints.column("frame_t_s"))[new] * 1e3
    yield Signal("frame_to_setpoint", "ms", vehicle.name, setpoints.t_s[new], latency)
    yield Signal("setpoint_gap", "ms", vehicle.name, setpoints.t_s[1:], np.diff(setpoints.t_s) * 1e3)
    velocity = setpoints.vectors("velocity_ned_m_s")
    for axis, direction in enumerate(("north", "east", "down")):
        yield Signal(f"setpoint_velocity_{direction}", "m_s", vehicle.name, setpoints.t_s, velocity[:, axis])


def _perception(vehicle: VehicleRun) -> Iterator[Signal]:
    obstacles = vehicle.recording.topic("/obstacles")
    yield Signal("perception_latency", "ms", vehicle.name, obstacles.t_s, timing.perception_latency_ms(obstacles))


def _links(run: Run, vehicle: VehicleRun) -> Iterator[Signal]:
    for other, heard in sorted(Subject(run, vehicle).heard.items()):
        flying = heard.is_done == 0
        yield Signal("link_age", "s", vehicle.name, heard.t_s[flying], heard.age_s[flying], f"of {other}")
    series = vehicle.recording.topic("/clocks")
    told: dict[str, list[tuple[float, float]]] = {}
    for t_s, offsets in zip(series.t_s.tolist(), series.values("offsets"), strict=True):
        for one in offsets or ():
            told.setdefault(str(one["vehicle"]), []).append((t_s, 1e3 * one["ahead_s"]))
    for other, rows in sorted(told.items()):
        t_s, ahead_ms = np.array(rows).T
        yield Signal("clock_offset", "ms", vehicle.name, t_s, ahead_ms, f"of {other}")


def _health(vehicle: VehicleRun) -> Iterator[Signal]:
    battery, health = vehicle.recording.topic("/battery"), vehicle.recording.topic("/health")
    yield Signal("battery", "percent", vehicle.name, battery.t_s, 100.0 * battery.column("remaining_fraction"))
    yield Signal("battery_voltage", "V", vehicle.name, battery.t_s, battery.column("voltage_v"))
    yield Signal("cpu", "percent", vehicle.name, health.t_s, 100.0 * health.column("cpu_fraction"))
    yield Signal("memory", "MB", vehicle.name, health.t_s, health.column("memory_mb"))
    yield Signal("loop_lateness", "ms", vehicle.name, health.t_s, health.column("loop_lateness_max_ms"))


def _world(run: Run) -> World | None:
    """The obstacles that the mission names; None if it names none: then the world is not known."""
    if run.mission is None or not (run.mission.obstacles.cylinders or run.mission.obstacles.boxes):
        return None
    return World(run.mission.obstacles)
