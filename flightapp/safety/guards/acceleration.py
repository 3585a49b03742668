"""How fast the velocity setpoint may change."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Limits, Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters

PERIOD_MIN_S, PERIOD_MAX_S = 1e-3, 0.2
PAUSE_MAX_S = 0.5
TOLERANCE_M_S = 1e-6
TOLERANCE_M_S2 = 1e-6


class AccelerationGuard:
    """Specification, against the setpoint sent last (the own velocity where there is none, or none for 0.5 s):

    - Braking passes at once: the part of the change that takes speed away along the last velocity, down to zero, is not
      limited, neither in acceleration nor in jerk. The vehicle brakes as hard as it can.
    - Everything else (gaining speed, turning, reversing beyond zero) is at most `acceleration_max * dt` a step, and its
      acceleration along the wanted change grows by at most `jerk_max * dt` a step.
    - The vertical speed by the same two rules, with `vertical_acceleration`.
    - Ceasing to accelerate is not limited: it would either carry the setpoint beyond the wish, or hold a wish back that itself
      grows step by step.
    - An acceleration feed-forward beyond the same limits is dropped.

    A control period longer than 0.2 s counts as 0.2 s: a gap in the loop does not buy a jump. What the spatial guards and the
    height band ask for after this guard, and a standstill for want of an own state, may exceed these limits, as braking must.
    """

    name = "acceleration"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._vertical_m_s2 = parameters.vertical_acceleration_m_s2
        self._last: tuple[float, list[float], float] | None = None
        """Of the last check: when, the setpoint that it started from, and its period."""

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        dt = min(max(context.dt_s, PERIOD_MIN_S), PERIOD_MAX_S)
        old, present = self._motion(context, dt)
        limits, wish = context.limits, setpoint.velocity_ned_m_s.tolist()
        north, east = _planar_step(old, wish, present, limits, dt)
        down = _vertical_step(old[2], wish[2], present[2], self._vertical_m_s2, limits.jerk_max_m_s3, dt)
        cut, vertical_cut = math.hypot(wish[0] - north, wish[1] - east), abs(wish[2] - down)
        if cut <= TOLERANCE_M_S and vertical_cut <= TOLERANCE_M_S:
            return self._with_feed_forward(setpoint, limits)
        reason = f"velocity changes too fast: {cut:.1f} m/s planar and {vertical_cut:.1f} m/s vertical put off"
        return self._with_feed_forward(with_velocity(setpoint, north, east, down), limits, reason)

    def _motion(self, context: SafetyContext, dt: float) -> tuple[list[float], list[float]]:
        """The velocity to start from and the acceleration of the last step towards it, each (3,)."""
        last, previous = self._last, context.previous
        paused = last is not None and not abs(context.t_s - last[0]) <= PAUSE_MAX_S
        fresh = previous is None or paused
        old: list[float] = (context.own if previous is None or fresh else previous).velocity_ned_m_s.tolist()
        self._last = (context.t_s, old, dt)
        if last is None or fresh:
            return old, [0.0, 0.0, 0.0]
        return old, [(now - before) / last[2] for now, before in zip(old, last[1], strict=True)]

    def _with_feed_forward(self, setpoint: Setpoint, limits: Limits, reason: str = "") -> GuardVerdict:
        """`reason`: why the velocity was changed."""
        if setpoint.acceleration_ned_m_s2 is None:
            return GuardVerdict(setpoint, reason)
        north, east, down = setpoint.acceleration_ned_m_s2.tolist()
        planar = math.hypot(north, east)
        if planar > limits.acceleration_max_m_s2 + TOLERANCE_M_S2 or abs(down) > self._vertical_m_s2 + TOLERANCE_M_S2:
            reason = f"acceleration of {planar:.1f} m/s2 planar and {abs(down):.1f} m/s2 vertical fed forward: dropped"
            return GuardVerdict(Setpoint(np.array(setpoint.velocity_ned_m_s), setpoint.yaw_rad), reason)
        return GuardVerdict(setpoint, reason)


def _planar_step(old: list[float], wish: list[float], present: list[float], limits: Limits, dt: float) -> tuple[float, float]:
    base_north, base_east = _braked(old, wish)
    change_north, change_east = wish[0] - base_north, wish[1] - base_east
    change = math.hypot(change_north, change_east)
    if change <= TOLERANCE_M_S:
        return wish[0], wish[1]
    along = max(0.0, (present[0] * change_north + present[1] * change_east) / change)
    step = min(limits.acceleration_max_m_s2, along + limits.jerk_max_m_s3 * dt) * dt
    if step >= change:
        return wish[0], wish[1]
    return base_north + change_north * step / change, base_east + change_east * step / change


def _braked(old: list[float], wish: list[float]) -> tuple[float, float]:
    """The old velocity after unlimited braking along itself towards the wish."""
    speed2 = old[0] * old[0] + old[1] * old[1]
    if speed2 < TOLERANCE_M_S:
        return old[0], old[1]
    share = min(1.0, max(0.0, (old[0] * wish[0] + old[1] * wish[1]) / speed2))
    return old[0] * share, old[1] * share


def _vertical_step(old: float, wish: float, present: float, acceleration_max: float, jerk_max: float, dt: float) -> float:
    base = min(max(wish, min(0.0, old)), max(0.0, old))
    along = max(0.0, math.copysign(present, present * (wish - base))) if wish != base else 0.0
    step = min(acceleration_max, along + jerk_max * dt) * dt
    return base + min(max(wish - base, -step), step)
