"""Old perception: without a picture of the obstacles the vehicle creeps and then stands."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters

STOP_AFTER_LIMITS = 3.0


class ObstaclesAgeGuard:
    """Specification: obstacles older than `obstacles_age_max_s` -> planar speed at most `unseen_speed_m_s`, same direction;
    older than three times that, or of unknown age -> no planar motion. Vertical speed and yaw are kept.
    """

    name = "obstacles-age"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._age_max_s = parameters.obstacles_age_max_s
        self._slow_m_s = parameters.unseen_speed_m_s

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        age = context.obstacles_age_s
        if age <= self._age_max_s:
            return GuardVerdict(setpoint)
        speed_max = self._slow_m_s if age <= STOP_AFTER_LIMITS * self._age_max_s else 0.0
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        speed = math.hypot(north, east)
        if speed <= speed_max:
            return GuardVerdict(setpoint)
        scale = speed_max / speed
        known = "no obstacle picture" if math.isinf(age) else f"obstacles are {age:.2f} s old, limit {self._age_max_s:.2f} s"
        return GuardVerdict(with_velocity(setpoint, north * scale, east * scale, down), f"{known}: at most {speed_max:.1f} m/s")
