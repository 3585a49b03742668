"""The planner's step, coarse and fine, with 40 discs in reach and two pursuers; and the roll-out against plain NumPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.rollout_reference import roll_out_reference
from flightapp.bench.situation import COARSE_DISTANCE_M, FINE_DISTANCE_M, circling, discs_around, observation, straight
from flightapp.core.types import Array, Limits, Observation
from flightapp.planning import make_planner
from flightapp.planning.ac2f.rollout import roll_out
from flightapp.planning.api import Planner

COARSE, FINE = "planner, coarse step", "planner, fine step"
DECISIONS = (COARSE, FINE)
COARSE_AIM_MS = 0.05
FINE_AIM_MS = 0.25
WARM_UP = 90
"""Periods until the own history is long enough for the fine stage to begin."""
ALWAYS_FINE = {"oscillation_variance_m2": 100.0, "fine_time_max_s": 1e6}
"""The fine stage with its full horizon and with the memory term: 441 samples x 10 steps."""
SAMPLES, STEPS, STEP_S = 21, 10, 0.1

RollOut = tuple[Array, Array, Array, Array, float, int, float, float, float, int]


def planner_measurements(limits: Limits, seconds: float) -> list[Measurement]:
    """Coarse step, fine step, roll-out kernel; `seconds` for all."""
    coarse = make_planner("ac2f", limits=limits)
    fine = make_planner("ac2f", limits=limits, parameters=ALWAYS_FINE)
    return [
        measure(
            Work(
                COARSE,
                lambda k: observation(straight(k), k, COARSE_DISTANCE_M),
                lambda seen: _step(coarse, seen, "coarse"),
                COARSE_AIM_MS,
                WARM_UP,
            ),
            0.3 * seconds,
        ),
        measure(
            Work(
                FINE,
                lambda k: observation(circling(k), k, FINE_DISTANCE_M),
                lambda seen: _step(fine, seen, "" if seen.t_s < WARM_UP / 30.0 - 0.5 else "fine"),
                FINE_AIM_MS,
                WARM_UP,
            ),
            0.4 * seconds,
        ),
        _roll_out(limits, 0.3 * seconds),
    ]


def _step(planner: Planner, seen: Observation, mode: str) -> None:
    found = planner.step(seen).mode
    if mode and found != mode:
        raise RuntimeError(f"the planner was in the stage '{found}' instead of '{mode}': this would measure something else")


def _roll_out(limits: Limits, seconds: float) -> Measurement:
    count = SAMPLES * SAMPLES
    paths, ends, clearances = np.zeros((count, STEPS, 2)), np.zeros((count, 3)), np.zeros(count)
    verdicts = np.zeros(count, dtype=np.int64)
    kernel = measure(
        Work(
            "planner, roll-out kernel",
            lambda k: _arguments(limits, k),
            lambda arguments: roll_out(*arguments, paths, ends, clearances, verdicts),
        ),
        seconds / 2,
    )
    plain = measure(
        Work("NumPy reference", lambda k: _arguments(limits, k), lambda arguments: roll_out_reference(*arguments)),
        seconds / 2,
    )
    return replace(kernel, faster_by=plain.cpu_ms.p50 / kernel.cpu_ms.p50)


def _arguments(limits: Limits, k: int) -> RollOut:
    """The input of one roll-out."""
    own = circling(k)
    discs = discs_around(own, k)
    scene = np.zeros((len(discs), 6))
    scene[:, :5] = discs[:, :5]
    scene[:, 2] += limits.body_radius_m + limits.safety_margin_m
    speeds = np.repeat(np.linspace(1.5, 2.5, SAMPLES), SAMPLES)
    turns = np.tile(np.linspace(-1.2, 1.2, SAMPLES), SAMPLES)
    start = np.array((own.position_ned_m[0], own.position_ned_m[1], own.yaw_rad))
    return start, speeds, turns, scene, STEP_S, STEPS, 2.0, 0.8 * limits.acceleration_max_m_s2, 0.4, 6
