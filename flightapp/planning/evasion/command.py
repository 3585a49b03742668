"""What every evader policy does with its wish: turn it into a decision."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Decision, Observation
from flightapp.planning.plane import Point, limited

TURNING_M_S = 0.2


def decision(observation: Observation, velocity: Point, goal: Point | None, mode: str, speed_max_m_s: float) -> Decision:
    """A planar decision: `velocity` (m/s) within the speed limit, nose along it."""
    velocity = limited(velocity, speed_max_m_s)
    moving = math.hypot(*velocity) > TURNING_M_S
    return Decision(
        velocity_ned_m_s=np.array((*velocity, 0.0)),
        acceleration_ned_m_s2=None,
        yaw_rad=wrap_pi(math.atan2(velocity[1], velocity[0]) if moving else observation.own.yaw_rad),
        mode=mode,
        goal_ned_m=None if goal is None else np.array((*goal, 0.0)),
        diagnostics={"stage": mode},
    )
