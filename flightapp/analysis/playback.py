"""What the page plays through: every vehicle's way and beliefs over time, small enough to be part of the page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flightapp.analysis.figures import span_s
from flightapp.analysis.map_data import map_data, origin_name, origin_s, vehicle_colours
from flightapp.analysis.outcome import captured_s
from flightapp.analysis.packed import packed, spread_out
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.signals import true_evader
from flightapp.analysis.spells import Spell, guard_spells, mode_spells, phase_spells
from flightapp.analysis.track import Track
from flightapp.core.types import Array

Part = dict[str, Any]
_SAMPLES_MAX = 4000
"""Of one way: more than three a second over 20 minutes; in between the page goes straight."""
_STEP_MIN_S = 0.04
_SCENES_MAX = 1200
"""Sets of discs and of circles that are kept of one vehicle."""
_SCENE_STEP_MIN_S = 0.2
_CIRCLES_MAX = 8
_SIGHT_MARGIN_M = 4.0


def playback_of(run: Run, ghosts: Sequence[Run] = ()) -> Part:
    """For the script of the page: times in s since the page's origin, positions in m north and east."""
    colours = vehicle_colours(run)
    span = span_s(run)
    return {
        "span_s": span,
        "origin": origin_name(run),
        "ground": _ground(run),
        "vehicles": [_vehicle(run, vehicle, colours[vehicle.name], span) for vehicle in run.vehicles],
        "truth": true_evader(run) is not None,
        "capture": _capture(run),
        "ghosts": [_ghost(number, ghost, span) for number, ghost in enumerate(ghosts)],
    }


def ghost_name(number: int, run: Run) -> str:
    """How a compared run is called on the page."""
    return f"{chr(ord('B') + number % 25)}: {run_name(run)}"


def run_name(run: Run) -> str:
    """The folder, or the recording where only one was named."""
    return run.prefix.rstrip("-") or Path(run.folder).resolve().name


def _ground(run: Run) -> Part:
    data = map_data(run)
    low_m, high_m = _sight(run) or (data.low_m, data.high_m)
    return {
        "fence": None if data.fence is None else _points(data.fence),
        "boundary": None if data.boundary is None else _points(data.boundary),
        "obstacles": [_points(outline) for outline in data.obstacles],
        "known": [_points(outline) for outline in data.known],
        "ways": [_points(way) for way in data.ways],
        "low_m": low_m,
        "high_m": high_m,
    }


def _sight(run: Run) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Corners of what was flown through, which is looked at first; None where nothing is known."""
    ways = [vehicle.track.position_ned_m[:, :2] for vehicle in run.vehicles if vehicle.track is not None]
    if not ways:
        return None
    low, high = np.concatenate(ways).min(axis=0) - _SIGHT_MARGIN_M, np.concatenate(ways).max(axis=0) + _SIGHT_MARGIN_M
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def _points(points_m: Array) -> list[list[float]]:
    return [[round(north, 3), round(east, 3)] for north, east in points_m[:, :2].tolist()]


def _vehicle(run: Run, vehicle: VehicleRun, colour: str, span: tuple[float, float]) -> Part:
    zero_s = origin_s(run)
    end_s = zero_s + span[1]
    return {
        "name": vehicle.name,
        "role": vehicle.role or "not known",
        "colour": colour,
        "source": None if vehicle.track is None else vehicle.track.source,
        "way": None if vehicle.track is None else _way(vehicle.track, zero_s, span, _headings(vehicle, vehicle.track)),
        "estimate": _estimate(vehicle, zero_s, span),
        "setpoint": _setpoint(vehicle, zero_s, span),
        "goal": _goal(vehicle, zero_s, span),
        "discs": _discs(vehicle, zero_s, span),
        "circles": _circles(vehicle, zero_s, span),
        "phases": _told(phase_spells(vehicle), zero_s, end_s),
        "modes": _told(mode_spells(vehicle), zero_s, end_s),
        "guards": _told(guard_spells(vehicle), zero_s, end_s),
    }


def _told(spells: Sequence[Spell], zero_s: float, end_s: float) -> list[Part]:
    return [
        {
            "from": round(spell.from_s - zero_s, 3),
            "to": round(min(spell.to_s, end_s) - zero_s, 3),
            "name": spell.name,
            "reason": spell.reason,
        }
        for spell in spells
    ]


def _step_s(span: tuple[float, float], count_max: int, least_s: float) -> float:
    return max(least_s, (span[1] - span[0]) / count_max)


def _way(track: Track, zero_s: float, span: tuple[float, float], heading_rad: Array) -> Part:
    chosen = spread_out(track.t_s, _step_s(span, _SAMPLES_MAX, _STEP_MIN_S))
    position, velocity = track.position_ned_m[chosen], track.velocity_ned_m_s[chosen]
    return {
        "t": packed(track.t_s[chosen] - zero_s),
        "north": packed(position[:, 0]),
        "east": packed(position[:, 1]),
        "height": packed(-position[:, 2]),
        "speed": packed(np.linalg.norm(velocity[:, :2], axis=1)),
        "heading": packed(heading_rad[chosen]),
    }


def _headings(vehicle: VehicleRun, track: Track) -> Array:
    """Where the nose pointed, unwrapped, rad; the direction of flight where that was not recorded."""
    own = vehicle.recording.topic("/own")
    yaw = own.column("yaw_rad")
    good = np.isfinite(yaw)
    if good.any():
        return np.interp(track.t_s, own.t_s[good], np.unwrap(yaw[good]))
    return np.unwrap(np.arctan2(track.velocity_ned_m_s[:, 1], track.velocity_ned_m_s[:, 0]))


def _estimate(vehicle: VehicleRun, zero_s: float, span: tuple[float, float]) -> Part | None:
    series = vehicle.recording.topic("/target")
    position = series.vectors("position_ned_m")
    good = np.flatnonzero(np.isfinite(position).all(axis=1))
    if len(good) == 0:
        return None
    chosen = good[spread_out(series.t_s[good], _step_s(span, _SAMPLES_MAX, _STEP_MIN_S))]
    return {
        "t": packed(series.t_s[chosen] - zero_s),
        "north": packed(position[chosen, 0]),
        "east": packed(position[chosen, 1]),
        "sigma": packed(series.column("position_sigma_m")[chosen]),
    }


def _setpoint(vehicle: VehicleRun, zero_s: float, span: tuple[float, float]) -> Part | None:
    series = vehicle.recording.topic("/setpoint")
    if len(series) == 0:
        return None
    chosen = spread_out(series.t_s, _step_s(span, _SAMPLES_MAX, _STEP_MIN_S))
    velocity = series.vectors("velocity_ned_m_s")[chosen]
    return {"t": packed(series.t_s[chosen] - zero_s), "north": packed(velocity[:, 0]), "east": packed(velocity[:, 1])}


def _goal(vehicle: VehicleRun, zero_s: float, span: tuple[float, float]) -> Part | None:
    series = vehicle.recording.topic("/decision")
    goal = series.vectors("goal_ned_m")
    if not np.isfinite(goal).any():
        return None
    chosen = spread_out(series.t_s, _step_s(span, _SAMPLES_MAX, _STEP_MIN_S))
    return {"t": packed(series.t_s[chosen] - zero_s), "north": packed(goal[chosen, 0]), "east": packed(goal[chosen, 1])}


def _discs(vehicle: VehicleRun, zero_s: float, span: tuple[float, float]) -> Part | None:
    series = vehicle.recording.topic("/obstacles")
    chosen = spread_out(series.t_s, _step_s(span, _SCENES_MAX, _SCENE_STEP_MIN_S))
    sets = [_rows(told) for told in series.messages.taken(chosen.tolist()).values("discs")]
    return _scenes(series.t_s[chosen] - zero_s, sets)


def _circles(vehicle: VehicleRun, zero_s: float, span: tuple[float, float]) -> Part | None:
    """Apollonius circles of a planner that plays that game: centre and radius."""
    series = vehicle.recording.topic("/decision")
    chosen = spread_out(series.t_s, _step_s(span, _SCENES_MAX, _SCENE_STEP_MIN_S))
    told = series.messages.taken(chosen.tolist()).values("diagnostics.circles")
    return _scenes(series.t_s[chosen] - zero_s, [_rows(one)[:_CIRCLES_MAX] for one in told])


def _rows(told: Any) -> Array:
    """(n, 3) north, east, radius of a list of rows; what is no such row, or not finite, is left out."""
    rows = [row[:3] for row in told if isinstance(row, list) and len(row) >= 3] if isinstance(told, list) else []
    plain = [row for row in rows if all(isinstance(value, (int, float)) and np.isfinite(value) for value in row)]
    return np.array(plain, dtype=np.float64).reshape(-1, 3)


def _scenes(t_s: Array, sets: list[Array]) -> Part | None:
    """Sets of circles over time: set k is rows start[k] to start[k + 1]."""
    if not any(len(one) for one in sets):
        return None
    start = np.concatenate(([0], np.cumsum([len(one) for one in sets])))
    return {"t": packed(t_s), "start": packed(start, "i4"), "rows": packed(np.concatenate(sets))}


def _capture(run: Run) -> Part | None:
    when_s, evader = captured_s(run), run.evader_track()
    if when_s is None or evader is None or not evader.t_s[0] <= when_s <= evader.t_s[-1]:
        return None
    north, east, _ = evader.at(np.array([when_s])).position_ned_m[0].tolist()
    return {"t": when_s - origin_s(run), "north": north, "east": east}


def _ghost(number: int, run: Run, span: tuple[float, float]) -> Part:
    """Another run, on its own time since its pursuit began."""
    zero_s = origin_s(run)
    ways = {vehicle.name: (vehicle.role, vehicle.track) for vehicle in run.vehicles if vehicle.track is not None}
    return {
        "name": ghost_name(number, run),
        "vehicles": [
            {"name": name, "role": role or "not known", "way": _way(track, zero_s, span, np.zeros(len(track)))}
            for name, (role, track) in ways.items()
        ],
    }
