"""How fast the yaw setpoint may turn."""

from __future__ import annotations

import math
from dataclasses import replace

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.acceleration import PAUSE_MAX_S, PERIOD_MAX_S, PERIOD_MIN_S
from flightapp.safety.guards.setpoints import held_yaw_rad

TOLERANCE_RAD = 1e-9


class YawRateGuard:
    """Specification: the yaw setpoint turns from the last one the short way round, at most at `yaw_rate_max`; its rate changes
    by at most `yaw_acceleration_max * dt` a step, and it slows down early enough to end at the wish without passing it.
    Where the wish turns back meanwhile, it is passed by what slowing down takes. Yaw held for want of an own state or a usable
    wish stops at once.
    """

    name = "yaw-rate"

    def __init__(self) -> None:
        self._last: tuple[float, float, float] | None = None
        """Of the last check: when, the yaw that it started from, and its period."""

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        dt = min(max(context.dt_s, PERIOD_MIN_S), PERIOD_MAX_S)
        old = held_yaw_rad(context)
        rate = self._rate(old, context, dt)
        change = context.limits.yaw_acceleration_max_rad_s2 * dt
        rate_max = context.limits.yaw_rate_max_rad_s
        wanted = wrap_pi(setpoint.yaw_rad - old)
        ended = math.copysign(min(rate_max, _rate_to_end(abs(wanted), change, dt)), wanted)
        allowed = min(max(ended, rate - change), rate + change)
        turn = min(max(allowed, -rate_max), rate_max) * dt
        if abs(turn - wanted) <= TOLERANCE_RAD:
            return GuardVerdict(setpoint)
        reason = f"turn of {math.degrees(wanted):.0f} deg wanted, {math.degrees(turn):.1f} deg fit into this period"
        return GuardVerdict(replace(setpoint, yaw_rad=wrap_pi(old + turn)), reason)

    def _rate(self, old: float, context: SafetyContext, dt: float) -> float:
        """Rate of the last step towards the yaw sent last; zero after a pause."""
        last = self._last
        self._last = (context.t_s, old, dt)
        if last is None or context.previous is None or not abs(context.t_s - last[0]) <= PAUSE_MAX_S:
            return 0.0
        return wrap_pi(old - last[1]) / last[2]


def _rate_to_end(turn: float, change: float, dt: float) -> float:
    """Largest rate from which a turn ends after exactly `turn`, slowing down by `change` a step of `dt`."""
    steps = math.ceil(0.5 * (math.sqrt(1.0 + 8.0 * turn / (change * dt)) - 1.0) - 1e-9)
    if steps <= 1:
        return turn / dt
    return turn / (steps * dt) + 0.5 * change * (steps - 1)
