"""One scene: planned once, then flown by every method on both plants in the same wind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from flightapp.config.wind import HarmonicWind
from flightapp.control.avoidance import AvoidanceGains
from flightapp.control.formation import FormationGains
from flightapp.core.types import Array
from flightapp.sim.control_study import flight as f
from flightapp.sim.control_study.methods import METHODS, Method, Plant
from flightapp.sim.control_study.reference import SPACING_S, Course, plan_course
from flightapp.sim.control_study.trace import error_of, lyapunov_of, sliding_of
from flightapp.sim.wind import drawn

FOLLOWERS = 4
DRAG_1_S = 0.3
ACCELERATION_MAX_M_S2 = 6.0
SETTLED_S = 6.0
PEAK_S = 5.0
START_OFFSET_M = 1.0
"""Along each axis: every vehicle starts off its place."""
TRACE_HZ = 50
GOAL_M = 2.0
SPACING_M = 4.5
"""Least distance of a pair that the acceptance asks for: 5 m less 0.5 m."""


@dataclass(frozen=True, slots=True)
class Setting:
    """One row of table 1. way: level, descent or climb."""

    name: str
    way: str = "level"
    obstacles: int = 17
    step_m: float = 2.0
    duration_s: float = 30.0


@dataclass(frozen=True, slots=True)
class Figures:
    """What a table shows as a mean over scenes; errors and distances in m, over all vehicles, from `leader_` on of the leader.

    peak: in the first PEAK_S. later: after SETTLED_S, mean; for an axis the largest. lyapunov: (|e|^2 + |its rate|^2) / 2, as the
    source prints it; its value at the start and 5 s later.
    """

    error_mean_m: float
    error_steady_m: float
    error_max_m: float
    error_std_m: float
    limited_share: float
    nearest_mean_m: float
    pair_mean_m: float
    pair_mean_min_m: float
    pair_mean_max_m: float
    pair_std_m: float
    formation_mean_m: float
    formation_max_m: float
    formation_std_m: float
    leader_peak_m: float
    leader_later_m: float
    north_later_m: float
    east_later_m: float
    down_peak_m: float
    down_later_m: float
    sliding_peak_m_s: float
    sliding_later_m_s: float
    lyapunov_start: float
    lyapunov_5_s: float


@dataclass(frozen=True, slots=True)
class Flown:
    """Of one method on one plant in one scene; distances in m, over all vehicles.

    arrived: the leader is within GOAL_M of its goal at the end. succeeded: arrived, nobody touched anything.
    """

    setting: str
    seed: int
    method: str
    plant: str
    succeeded: bool
    arrived: bool
    clearance_min_m: float
    pair_min_m: float
    repulsion_gain_max: float
    emergencies: int
    figures: Figures

    def as_json(self) -> dict[str, object]:
        told = asdict(self)
        return {**told, **told.pop("figures")}


@dataclass(frozen=True, slots=True)
class FlownScene:
    """All flights of one seed in one setting. `reason`: why there is no course; then nothing flew."""

    setting: str
    seed: int
    reason: str
    length_m: float
    wedge_share: float
    flights: tuple[Flown, ...]


def fly_scene(setting: Setting, seed: int, methods: Sequence[str], plants: Sequence[Plant]) -> FlownScene:
    """Plan the course of `seed` and fly it with `methods` on `plants`."""
    course = plan_course(seed, setting.way, setting.obstacles, setting.step_m, FOLLOWERS)
    if isinstance(course, str):
        return FlownScene(setting.name, seed, course, math.nan, math.nan, ())
    flights = tuple(fly_one(setting, seed, course, METHODS[name], plant)[0] for plant in plants for name in methods)
    return FlownScene(setting.name, seed, "", course.length_m, course.wedge_share, flights)


def fly_one(setting: Setting, seed: int, course: Course, method: Method, plant: Plant) -> tuple[Flown, Array]:
    """The figures, and the leader's trace (k, TRACE_COLUMNS)."""
    measures = np.zeros(f.MEASURES)
    trace = np.zeros((round(setting.duration_s * TRACE_HZ), f.PLACES_FROM + 3 * len(course.references)))
    f.fly_formation(
        np.array(
            (
                method.kind,
                plant.period_steps,
                plant.lag_s,
                plant.delay_steps,
                ACCELERATION_MAX_M_S2,
                DRAG_1_S,
                1.0,
                SPACING_S,
                SETTLED_S,
            )
        ),
        method.gains(plant),
        AvoidanceGains().as_array(),
        FormationGains().as_array(),
        course.references,
        course.bodies,
        np.ascontiguousarray(course.references[:, 0, :3] + START_OFFSET_M),
        drawn(HarmonicWind(), seed),
        round(setting.duration_s / f.STEP_S),
        measures,
        trace,
    )
    return _measured(setting, seed, method, plant, measures, trace), trace


def _measured(setting: Setting, seed: int, method: Method, plant: Plant, m: Array, trace: Array) -> Flown:
    arrived = bool(m[f.MISSED_GOAL] <= GOAL_M)
    return Flown(
        setting=setting.name,
        seed=seed,
        method=method.label,
        plant=plant.name,
        succeeded=arrived and bool(m[f.CLEARANCE] > 0.0) and bool(m[f.PAIR_MIN] > 2.0 * AvoidanceGains().hull_m),
        arrived=arrived,
        clearance_min_m=float(m[f.CLEARANCE]),
        pair_min_m=float(m[f.PAIR_MIN]),
        repulsion_gain_max=float(m[f.GAIN_MAX]),
        emergencies=int(m[f.EMERGENCIES]),
        figures=_figures(m, trace),
    )


def _figures(m: Array, trace: Array) -> Figures:
    error, spacing, formation = (
        m[f.ERROR] / m[f.COUNT],
        m[f.PAIR_MEAN] / m[f.SPACING_COUNT],
        m[f.FORMATION] / m[f.FORMATION_COUNT],
    )
    first, later = trace[:, 0] <= PEAK_S, trace[:, 0] >= SETTLED_S
    off, sliding, lyapunov = error_of(trace), sliding_of(trace), lyapunov_of(trace)
    axes = np.abs(trace[:, 10:13])
    return Figures(
        error_mean_m=float(error),
        error_steady_m=float(m[f.STEADY] / m[f.STEADY_COUNT]),
        error_max_m=float(m[f.ERROR_MAX]),
        error_std_m=_spread(m[f.ERROR_SQUARED] / m[f.COUNT], error),
        limited_share=float(m[f.LIMITED] / m[f.COUNT]),
        nearest_mean_m=float(m[f.NEAREST_MEAN] / m[f.SPACING_COUNT]),
        pair_mean_m=float(spacing),
        pair_mean_min_m=float(m[f.PAIR_MEAN_MIN]),
        pair_mean_max_m=float(m[f.PAIR_MAX]),
        pair_std_m=_spread(m[f.PAIR_SQUARED] / m[f.SPACING_COUNT], spacing),
        formation_mean_m=float(formation),
        formation_max_m=float(m[f.FORMATION_MAX]),
        formation_std_m=_spread(m[f.FORMATION_SQUARED] / m[f.FORMATION_COUNT], formation),
        leader_peak_m=float(off[first].max()),
        leader_later_m=float(off[later].mean()),
        north_later_m=float(axes[later, 0].max()),
        east_later_m=float(axes[later, 1].max()),
        down_peak_m=float(axes[first, 2].max()),
        down_later_m=float(axes[later, 2].max()),
        sliding_peak_m_s=float(sliding[first].max()),
        sliding_later_m_s=float(sliding[later].mean()),
        lyapunov_start=float(lyapunov[0]),
        lyapunov_5_s=float(lyapunov[int(PEAK_S * TRACE_HZ)]),
    )


def _spread(mean_square: float, mean: float) -> float:
    return math.sqrt(max(0.0, float(mean_square) - float(mean) ** 2))
