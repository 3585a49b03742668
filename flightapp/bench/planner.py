"""The planner's step, coarse and fine, with 40 discs in reach and two pursuers; and the fine evaluation against plain NumPy."""

from __future__ import annotations

from dataclasses import replace

from flightapp.bench.fine_evaluation import fine_measurement
from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import far, near
from flightapp.core.types import Limits, Observation
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.api import Planner
from flightapp.planning.registry import make_planner

COARSE, FINE = "planner, coarse step", "planner, fine step"
IN_SPACE = "planner in space, coarse step"
DECISIONS = (COARSE, FINE)
COARSE_AIM_MS = 0.05
FINE_AIM_MS = 0.25
IN_SPACE_AIM_MS = 0.5
WARM_UP = 90
"""Periods until the own history is long enough for the fine stage to begin."""
ALWAYS_FINE = {"oscillation_variance_m2": 100.0, "fine_time_max_s": 1e6}
"""The fine stage with its full horizon and with the memory term: 441 samples x 10 steps."""
LOW_DOWN_M = (-2.0, 0.0)
"""Top and underside of every other disc of the flight in space, which passes over it."""


def planner_measurements(limits: Limits, seconds: float) -> list[Measurement]:
    """Coarse step, fine step, fine evaluation, coarse step in space; `seconds` for all."""
    coarse = make_planner("ac2f", limits=limits)
    fine = make_planner("ac2f", limits=limits, parameters=ALWAYS_FINE)
    coarse_step = measure(
        Work(
            COARSE,
            far,
            lambda seen: _step(coarse, seen, "coarse"),
            COARSE_AIM_MS,
            WARM_UP,
        ),
        0.2 * seconds,
    )
    fine_step = measure(
        Work(
            FINE,
            near,
            lambda seen: _step(fine, seen, "" if seen.t_s < WARM_UP / 30.0 - 0.5 else "fine"),
            FINE_AIM_MS,
            WARM_UP,
        ),
        0.4 * seconds,
    )
    evaluation, plain_ms = fine_measurement(limits, Ac2fParameters.model_validate(ALWAYS_FINE), 0.3 * seconds)
    spatial = make_planner("ac2f", limits=limits, parameters={"volume": {"space": "volume"}})
    work = Work(IN_SPACE, far_in_space, lambda seen: _step(spatial, seen, "coarse"), IN_SPACE_AIM_MS, WARM_UP)
    spatial_step = measure(work, 0.1 * seconds)
    return [coarse_step, replace(fine_step, faster_by=plain_ms / fine_step.cpu_ms.p50), evaluation, spatial_step]


def far_in_space(k: int) -> Observation:
    """`far` with an evader that climbs, 2 m above, and low obstacles."""
    seen = far(k)
    discs = seen.obstacles.discs.copy()
    discs[::2, 5:] = LOW_DOWN_M
    target = seen.target
    if target is not None:
        place, velocity = target.position_ned_m.copy(), target.velocity_ned_m_s.copy()
        place[2], velocity[2] = place[2] - 2.0, -1.0
        target = replace(target, position_ned_m=place, velocity_ned_m_s=velocity)
    return replace(seen, target=target, obstacles=replace(seen.obstacles, discs=discs))


def _step(planner: Planner, seen: Observation, mode: str) -> None:
    found = planner.step(seen).mode
    if mode and found != mode:
        raise RuntimeError(f"the planner was in the stage '{found}' instead of '{mode}': this would measure something else")
