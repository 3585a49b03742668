"""Climb rate and height band."""

from __future__ import annotations

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import vertical_braking
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters


class AltitudeGuard:
    """Specification: |vertical speed| at most the climb rate limit; climbing no faster than can be braked `height_margin_m`
    below the top of the band, sinking no faster than can be braked that far above its bottom; beyond an edge, only motion
    back. Heights are metres above the datum, height = -down. Planar velocity and yaw are kept.
    """

    name = "altitude"

    def __init__(self, height_min_m: float, height_max_m: float, parameters: SafetyParameters) -> None:
        margin = min(parameters.height_margin_m, 0.25 * (height_max_m - height_min_m))
        self._lowest_m, self._highest_m = height_min_m + margin, height_max_m - margin
        self._braking = vertical_braking(parameters)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        height, climb = -float(context.own.position_ned_m[2]), -float(context.own.velocity_ned_m_s[2])
        age = context.own_age_s
        rate = context.limits.climb_rate_max_m_s
        above = self._highest_m - height - self._braking.reach_m(climb, age)
        below = height - self._lowest_m - self._braking.reach_m(-climb, age)
        up_max = min(rate, self._braking.speed_m_s(above))
        sink_max = min(rate, self._braking.speed_m_s(below))
        if -down > up_max:
            reason = f"height {height:.1f} m, top {self._highest_m:.1f} m: climbing at most {up_max:.1f} m/s"
            return GuardVerdict(with_velocity(setpoint, north, east, -up_max), reason)
        if down > sink_max:
            reason = f"height {height:.1f} m, bottom {self._lowest_m:.1f} m: sinking at most {sink_max:.1f} m/s"
            return GuardVerdict(with_velocity(setpoint, north, east, sink_max), reason)
        return GuardVerdict(setpoint)
