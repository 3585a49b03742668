"""Old target: an evader that was not measured for long may have turned round."""

from __future__ import annotations

import math

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.guards.target_keep_out import WIDENING_MAX_M
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound


class TargetAgeGuard:
    """Specification: while the evader's track is older than `target_age_max_s` (or of unknown age), the speed towards its
    predicted place is at most what can be braked `target_keep_out_m` and 1 m before it, as before something that stands:
    nothing is added for a flight that is only predicted. Zero always passes, and so does leaving.
    """

    name = "target-age"

    def __init__(self, parameters: SafetyParameters) -> None:
        self._parameters = parameters

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:  # noqa: ARG002
        target = context.target
        if target is None or target.age_s <= self._parameters.target_age_max_s:
            return []
        own_north, own_east, _ = context.own.position_ned_m.tolist()
        v_north, v_east, _ = context.own.velocity_ned_m_s.tolist()
        north, east, _ = target.position_ned_m.tolist()
        to_n, to_e = north - own_north, east - own_east
        distance = math.hypot(to_n, to_e)
        to_n, to_e = (to_n / distance, to_e / distance) if distance > 1e-6 else (1.0, 0.0)
        braking = horizontal_braking(context.limits, self._parameters)
        left = distance - self._parameters.target_keep_out_m - WIDENING_MAX_M
        bound = braking.speed_m_s(left - braking.reach_m(to_n * v_north + to_e * v_east, context.own_age_s))
        if not bound < speed_m_s:
            return []
        what = f"evader, not measured for {target.age_s:.1f} s,"
        return [VelocityBound(to_n, to_e, bound, self.name, what, distance)]
