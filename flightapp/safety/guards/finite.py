"""Nothing that is not a number reaches the autopilot, which accepts NaN without a word."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import standstill
from flightapp.safety.usable import FAR_M


class FiniteGuard:
    """Specification: a velocity or yaw that is NaN or infinite becomes zero velocity with yaw held, and so does everything when
    the own state is (or lies 1000 km away).

    Without an own state the verdict is final; otherwise the other guards go on from zero velocity, so that pushes and retreats
    remain. An acceleration that is not finite is dropped and the rest passes. The output is always finite.
    """

    name = "finite"

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        own = context.own
        numbers = [*own.position_ned_m.tolist(), *own.velocity_ned_m_s.tolist(), own.yaw_rad, context.dt_s]
        if not all(abs(number) < FAR_M for number in numbers):
            return GuardVerdict(standstill(context), "own state is not finite", final=True)
        velocity = setpoint.velocity_ned_m_s.tolist()
        if not all(map(math.isfinite, velocity)) or not math.isfinite(setpoint.yaw_rad):
            return GuardVerdict(standstill(context), "planner gave a setpoint that is not finite")
        forward = setpoint.acceleration_ned_m_s2
        if forward is not None and not all(map(math.isfinite, forward.tolist())):
            bare = Setpoint(setpoint.velocity_ned_m_s, setpoint.yaw_rad)
            return GuardVerdict(bare, "planner gave an acceleration that is not finite")
        return GuardVerdict(setpoint)
