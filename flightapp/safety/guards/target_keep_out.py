"""Distance from the evader."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound

WIDENING_MAX_M = 1.0


class TargetKeepOutGuard:
    """Specification: the closing speed relative to the evader is at most what can be braked before `target_keep_out_m`,
    widened by the track's age times the evader's speed (at most 1 m). An evader that comes closer faster than that is retreated
    from; one that flees may be followed at its speed. Nothing is asked without a track.
    """

    name = "target-keep-out"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._parameters = parameters

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:  # noqa: ARG002
        target = context.target
        if target is None:
            return []
        own_north, own_east, _ = context.own.position_ned_m.tolist()
        v_north, v_east, _ = context.own.velocity_ned_m_s.tolist()
        north, east, _ = target.position_ned_m.tolist()
        their_north, their_east, _ = target.velocity_ned_m_s.tolist()
        if not math.isfinite(north + east + their_north + their_east):
            return []
        to_n, to_e = north - own_north, east - own_east
        distance = math.hypot(to_n, to_e)
        to_n, to_e = (to_n / distance, to_e / distance) if distance > 1e-6 else (1.0, 0.0)
        braking = horizontal_braking(context.limits, self._parameters)
        opening = to_n * their_north + to_e * their_east
        widening = min(WIDENING_MAX_M, max(0.0, target.age_s) * math.hypot(their_north, their_east))
        left = distance - self._parameters.target_keep_out_m - widening
        left -= braking.reach_m(to_n * v_north + to_e * v_east - opening, context.own_age_s)
        bound = max(braking.speed_m_s(left) + opening, -context.limits.speed_max_m_s)
        return [VelocityBound(to_n, to_e, bound, self.name, "evader", distance)] if bound < speed_m_s else []
