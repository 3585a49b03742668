"""What is compared: the potential field, its modules added in the source's order, and one method built from a summary."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.planning.adaptive_apf.gains import Gains
from flightapp.planning.adaptive_apf.paper_step import STEP_S

STATIC_GAINS, MOVING_GAINS = (17.0, 5.0), (15.0, 10.0)
"""Attraction and repulsion of table 3, and of tables 5 and 6."""
ATTRACTION_REACH_M = 2.0
"""The source's threshold omega, which none of its equations uses."""
REACH_M = 2.0


@dataclass(frozen=True, slots=True)
class Method:
    """Modules "" to "ABCD"; inertia: see `paper_step.fly_steps`."""

    name: str
    modules: str
    inertia_1_s: float = 0.0
    only_closing: bool = False


METHODS: dict[str, Method] = {
    one.name: one
    for one in (
        Method("APF", ""),
        Method("APF+A", "A"),
        Method("APF+A+B", "AB"),
        Method("APF+A+B+C", "ABC"),
        Method("A-APF", "ABCD"),
        Method("IAPF-style", "A", inertia_1_s=4.0, only_closing=True),
    )
}
PRINTED = {
    "APF": (91.0, 15.38, 67.50),
    "APF+A": (92.3, 15.12, 59.24),
    "APF+A+B": (93.6, 15.07, 43.67),
    "APF+A+B+C": (94.1, 14.96, 38.65),
    "A-APF": (96.3, 14.79, 27.89),
    "IAPF-style": (95.7, 14.87, 32.45),
}
"""Tables 7 and 8: success in %, length in m, largest turn rate in deg/s."""


def gains_of(method: Method, step_m: float, printed: tuple[float, float], *, literal: bool = False) -> Gains:
    """For attraction and repulsion as printed, one step being `paper_step.STEP_S`.

    literal: attraction without limit and repulsion by the square of the distance to the goal, which belong together; else both
    are bounded, as the flown planner has them.
    """
    attraction, repulsion = printed
    full = attraction * ATTRACTION_REACH_M
    a, c, d = (1.0 if module in method.modules else 0.0 for module in "ACD")
    return Gains(
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
        adaptive=d,
        printed=1.0,
        reach_m=REACH_M,
        reach_min_m=0.5,
        reach_max_m=15.0,
        obstacle_s=0.1,
        only_closing=1.0 if method.only_closing else 0.0,
    )
