"""Climb and sink above and below known obstacles."""

from __future__ import annotations

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.heights import vertical_rates
from flightapp.safety.parameters import SafetyParameters


class ObstacleHeightGuard:
    """Specification: above a known obstacle of known height that the vehicle passes, and that is nearer than it could stop
    before, it sinks no faster than can be braked `obstacle_height_margin_m` above the top, the body in between; nearer to it than
    half of that margin it is brought up again, as by the fence. Below an obstacle that ends above the vehicle it climbs no
    faster, accordingly. Between two that contradict each other it stands. Planar velocity and yaw are kept; without known
    heights nothing is changed.
    """

    name = "obstacle-height"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._parameters = parameters

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        rates = vertical_rates(context, (north, east), self._parameters)
        if -rates.climb_max_m_s <= down <= rates.sink_max_m_s:
            return GuardVerdict(setpoint)
        allowed = _between(-rates.climb_max_m_s, rates.sink_max_m_s, down)
        if down > rates.sink_max_m_s:
            reason = f"above an obstacle: sink rate at most {rates.sink_max_m_s:.1f} m/s"
        else:
            reason = f"below an obstacle: climb rate at most {rates.climb_max_m_s:.1f} m/s"
        return GuardVerdict(with_velocity(setpoint, north, east, allowed), reason)


def _between(low: float, high: float, wanted: float) -> float:
    """`wanted` within [low, high]; where the two contradict each other, what the one that asks for less allows, or nothing."""
    if low <= high:
        return min(high, max(low, wanted))
    return low if low <= 0.0 else max(0.0, high)
