"""Nothing that is not a number reaches the autopilot, which accepts NaN without a word."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import standstill, with_velocity


class FiniteGuard:
    """Specification: a velocity or yaw that is NaN or infinite, or an own state that is, becomes zero velocity with yaw held.

    An acceleration that is not finite is dropped and the rest passes. The output is always finite.
    """

    name = "finite"

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        velocity = setpoint.velocity_ned_m_s.tolist()
        if not all(map(math.isfinite, velocity)) or not math.isfinite(setpoint.yaw_rad):
            return GuardVerdict(standstill(context), "planner gave a setpoint that is not finite")
        own = context.own
        numbers = [*own.position_ned_m.tolist(), *own.velocity_ned_m_s.tolist(), own.yaw_rad, context.dt_s]
        if not all(map(math.isfinite, numbers)):
            return GuardVerdict(standstill(context), "own state is not finite")
        acceleration = setpoint.acceleration_ned_m_s2
        if acceleration is not None and not all(map(math.isfinite, acceleration.tolist())):
            return GuardVerdict(with_velocity(setpoint, *velocity), "planner gave an acceleration that is not finite")
        return GuardVerdict(setpoint)
