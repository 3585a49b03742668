"""Top speed in the plane."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity

TOLERANCE_M_S = 1e-9


class SpeedGuard:
    """Specification: planar speed at most the vehicle's limit and its own limit in this mission; the direction is kept."""

    name = "speed"

    def __init__(self, mission_speed_max_m_s: float | None = None) -> None:
        self._mission_m_s = math.inf if mission_speed_max_m_s is None else mission_speed_max_m_s

    def speed_max_m_s(self, context: SafetyContext) -> float:
        return min(context.limits.speed_max_m_s, self._mission_m_s)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        speed, speed_max = math.hypot(north, east), self.speed_max_m_s(context)
        if speed <= speed_max + TOLERANCE_M_S:
            return GuardVerdict(setpoint)
        scale = speed_max / speed
        return GuardVerdict(
            with_velocity(setpoint, north * scale, east * scale, down), f"{speed:.1f} m/s wanted, limit {speed_max:.1f} m/s"
        )
