"""Climb rate and height band."""

from __future__ import annotations

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import vertical_braking
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.parameters import SafetyParameters


class AltitudeGuard:
    """Specification: climb and sink rate at most their limits; climbing no faster than can be braked `height_margin_m`
    below the top of the band, sinking no faster than can be braked that far above its bottom; nearer to an edge than half of
    that margin and beyond it, the vehicle is brought back as by the fence, at most at `push_back_m_s`. Heights are metres above
    the datum, height = -down. Planar velocity and yaw are kept.
    """

    name = "altitude"

    def __init__(self, height_min_m: float, height_max_m: float, parameters: SafetyParameters) -> None:
        self._margin_m = min(parameters.height_margin_m, 0.25 * (height_max_m - height_min_m))
        self._bottom_m, self._top_m = height_min_m, height_max_m
        self._push_back_m_s = parameters.push_back_m_s
        self._braking = vertical_braking(parameters)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        height, climb = -float(context.own.position_ned_m[2]), -float(context.own.velocity_ned_m_s[2])
        limits = context.limits
        rates = limits.climb_rate_max_m_s, limits.sink_rate_max_m_s
        climb_max = self._kept_m_s(self._top_m - height, climb, rates, context)
        sink_max = self._kept_m_s(height - self._bottom_m, -climb, rates[::-1], context)
        if -down > climb_max:
            reason = f"height {height:.1f} m, top {self._top_m:.1f} m: climb rate at most {climb_max:.1f} m/s"
            return GuardVerdict(with_velocity(setpoint, north, east, -climb_max), reason)
        if down > sink_max:
            reason = f"height {height:.1f} m, bottom {self._bottom_m:.1f} m: sink rate at most {sink_max:.1f} m/s"
            return GuardVerdict(with_velocity(setpoint, north, east, sink_max), reason)
        return GuardVerdict(setpoint)

    def _kept_m_s(self, inside_m: float, closing_m_s: float, rates_m_s: tuple[float, float], context: SafetyContext) -> float:
        """rates_m_s: the largest towards the edge and away from it."""
        allowed = self._braking.kept_m_s(inside_m, closing_m_s, self._margin_m, self._push_back_m_s, context.own_age_s)
        return min(rates_m_s[0], max(-rates_m_s[1], allowed))
