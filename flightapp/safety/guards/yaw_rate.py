"""How fast the yaw setpoint may turn."""

from __future__ import annotations

import math

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.acceleration import PERIOD_MAX_S
from flightapp.safety.guards.setpoints import held_yaw_rad

TOLERANCE_RAD = 1e-9


class YawRateGuard:
    """Specification: the yaw setpoint turns from the last one by at most `yaw_rate_max * dt`, the short way round."""

    name = "yaw-rate"

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        old = held_yaw_rad(context)
        step = context.limits.yaw_rate_max_rad_s * min(max(context.dt_s, 1e-3), PERIOD_MAX_S)
        turn = wrap_pi(setpoint.yaw_rad - old)
        if abs(turn) <= step + TOLERANCE_RAD:
            return GuardVerdict(setpoint)
        yaw = wrap_pi(old + math.copysign(step, turn))
        reason = f"turn of {math.degrees(turn):.0f} deg wanted, {math.degrees(step):.0f} deg fit into this period"
        return GuardVerdict(Setpoint(setpoint.velocity_ned_m_s, yaw, setpoint.acceleration_ned_m_s2), reason)
