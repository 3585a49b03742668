"""What is compared: the potential field, its modules added in the source's order, and two methods built from summaries."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from flightapp.planning.adaptive_apf.gains import Gains
from flightapp.planning.adaptive_apf.paper_step import STEP_S

STATIC_GAINS, MOVING_GAINS = (17.0, 5.0), (15.0, 10.0)
"""Attraction and repulsion of table 3, and of tables 5 and 6."""
ATTRACTION_REACH_M = 2.0
"""The source's threshold omega, which none of its equations uses."""
REACH_M = 2.0
INERTIA_1_S = 4.0


@dataclass(frozen=True, slots=True)
class Method:
    """Modules "" to "ABCD"; inertial: see `paper_step.fly_steps`.

    ranges: what is searched, a field of Gains or "inertia_1_s", and between what; search: by random draws or by grey wolves.
    """

    name: str
    modules: str
    inertial: bool = False
    only_closing: bool = False
    search: Literal["", "draws", "wolves"] = ""
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)


METHODS: dict[str, Method] = {
    one.name: one
    for one in (
        Method("APF", ""),
        Method("APF+A", "A"),
        Method("APF+A+B", "AB"),
        Method("APF+A+B+C", "ABC"),
        Method("A-APF", "ABCD"),
        Method(
            "IAPF-style",
            "A",
            inertial=True,
            only_closing=True,
            search="draws",
            ranges={"attraction_1_s2": (1.0, 30.0), "repulsion": (1.0, 50.0), "reach_m": (0.5, 5.0), "inertia_1_s": (1.0, 10.0)},
        ),
        Method(
            "GWO-APF",
            "A",
            search="wolves",
            ranges={"repulsion": (1.0, 50.0), "reach_m": (0.5, 8.0), "goal_power": (2.0, 4.0), "goal_scale_min_m": (1.0, 12.0)},
        ),
    )
}
PRINTED: Mapping[str, tuple[float, float, float, float]] = {
    "APF": (91.0, 4.35, 15.38, 67.50),
    "APF+A": (92.3, 4.18, 15.12, 59.24),
    "APF+A+B": (93.6, 3.97, 15.07, 43.67),
    "APF+A+B+C": (94.1, 3.76, 14.96, 38.65),
    "A-APF": (96.3, 3.40, 14.79, 27.89),
    "IAPF-style": (95.7, 3.86, 14.87, 32.45),
    "GWO-APF": (95.1, 3.94, 14.96, 31.68),
}
"""Tables 7 and 8: success in %, time in s, length in m, largest turn rate in deg/s."""
PRINTED_ONLY: Mapping[str, tuple[float, float, float, float]] = {"DDPG-APF": (93.2, 4.12, 15.12, 45.17)}
"""Not flown: a policy that was learned, of which nothing but this is known."""


def gains_of(
    method: Method,
    step_m: float,
    printed: tuple[float, float],
    *,
    literal: bool = False,
    searched: Mapping[str, float] | None = None,
) -> Gains:
    """For attraction and repulsion as printed, one step being `paper_step.STEP_S`; what was `searched` takes their place.

    literal: attraction without limit and repulsion by the square of the distance to the goal, which belong together, and the
    return force by zones; else these are bounded, as the flown planner has them.
    """
    attraction, repulsion = printed
    full = attraction * ATTRACTION_REACH_M
    a, c, d = (1.0 if module in method.modules else 0.0 for module in "ACD")
    gains = Gains(
        attraction_1_s2=attraction,
        attraction_reach_m=math.inf if literal else ATTRACTION_REACH_M,
        repulsion=repulsion,
        gap_min_m=0.05,
        force_max_m_s2=math.inf,
        goal_aware=a,
        goal_power=2.0,
        goal_bounded=0.0 if literal else 1.0,
        goal_scale_min_m=4.0,
        predictive=c,
        kinematic=1.0,
        steering_m_s2=full,
        braking_m_s2=0.0,
        speed_m_s=step_m / STEP_S,
        horizon_s=5.0,
        delay_s=0.0,
        body_radius_m=0.0,
        margin_m=0.3,
        vertical_weight=1.0,
        return_1_s2=1.0,
        return_max_m_s2=0.3 * full,
        return_zones=1.0 if literal else 0.0,
        adaptive=d,
        printed=1.0,
        reach_m=REACH_M,
        reach_min_m=0.5,
        reach_max_m=15.0,
        obstacle_s=0.1,
        only_closing=1.0 if method.only_closing else 0.0,
    )
    return gains._replace(**{name: value for name, value in (searched or {}).items() if name in Gains._fields})


def inertia_of(method: Method, searched: Mapping[str, float]) -> float:
    """Damping per second of a method that is inertial; 0: along the force at once."""
    return searched.get("inertia_1_s", INERTIA_1_S) if method.inertial else 0.0
