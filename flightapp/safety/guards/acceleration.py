"""How fast the velocity setpoint may change."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters

PERIOD_MAX_S = 0.2
TOLERANCE_M_S = 1e-6


class AccelerationGuard:
    """Specification, against the setpoint sent last (the own velocity where there is none):

    - Braking passes at once: the part of the change that takes speed away along the last velocity, down to zero, is not
      limited, neither in acceleration nor in jerk. The vehicle brakes as hard as it can.
    - Everything else (gaining speed, turning, reversing beyond zero) is at most `acceleration_max * dt` a step, and its
      acceleration along the wanted change grows by at most `jerk_max * dt` a step. Ceasing to accelerate is not limited.
    - Vertical speed: growing its magnitude by at most `vertical_acceleration * dt`, shrinking it to zero at once.

    A control period longer than 0.2 s counts as 0.2 s: a gap in the loop does not buy a jump.
    """

    name = "acceleration"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._vertical_m_s2 = parameters.vertical_acceleration_m_s2
        self._last: tuple[float, float] | None = None

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        sent = context.own.velocity_ned_m_s if context.previous is None else context.previous.velocity_ned_m_s
        old_north, old_east, old_down = sent.tolist()
        older = self._last if context.previous is not None and self._last is not None else (old_north, old_east)
        self._last = (old_north, old_east)
        dt = min(max(context.dt_s, 1e-3), PERIOD_MAX_S)
        wish_north, wish_east, wish_down = setpoint.velocity_ned_m_s.tolist()

        base_north, base_east = _braked((old_north, old_east), (wish_north, wish_east))
        change_north, change_east = wish_north - base_north, wish_east - base_east
        change = math.hypot(change_north, change_east)
        limits = context.limits
        scale = 1.0
        if change > TOLERANCE_M_S:
            present = ((old_north - older[0]) * change_north + (old_east - older[1]) * change_east) / (change * dt)
            acceleration = min(limits.acceleration_max_m_s2, max(0.0, present) + limits.jerk_max_m_s3 * dt)
            scale = min(1.0, acceleration * dt / change)
        down = _vertical_step(old_down, wish_down, self._vertical_m_s2 * dt)
        if scale == 1.0 and abs(down - wish_down) <= TOLERANCE_M_S:
            return GuardVerdict(setpoint)
        north, east = base_north + scale * change_north, base_east + scale * change_east
        cut = math.hypot(wish_north - north, wish_east - east)
        reason = f"velocity changes too fast: {cut:.1f} m/s planar and {abs(wish_down - down):.1f} m/s vertical put off"
        return GuardVerdict(with_velocity(setpoint, north, east, down), reason)


def _braked(old: tuple[float, float], wish: tuple[float, float]) -> tuple[float, float]:
    """The old velocity after unlimited braking along itself towards the wish."""
    speed2 = old[0] * old[0] + old[1] * old[1]
    if speed2 < TOLERANCE_M_S:
        return old
    share = min(1.0, max(0.0, (old[0] * wish[0] + old[1] * wish[1]) / speed2))
    return old[0] * share, old[1] * share


def _vertical_step(old: float, wish: float, step: float) -> float:
    base = min(max(wish, min(0.0, old)), max(0.0, old))
    return base + min(max(wish - base, -step), step)
