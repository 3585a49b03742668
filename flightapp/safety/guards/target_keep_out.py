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
ON_ITS_PATH_M = 0.01
"""A vehicle this near to the middle of the evader's path is on neither side of it."""
COMES_M_S = 0.5
"""An evader slower than this stands, or its track is noisy: retreating from it is enough, and does not swing to and fro."""
HURRY = 0.5
"""Share of the time until the closest approach in which the path is left; the vehicle must gain the speed for it first."""


class TargetKeepOutGuard:
    """Specification: the closing speed relative to the evader is at most what can be braked before `target_keep_out_m`,
    widened by the track's age times the evader's speed (at most 1 m). An evader that comes closer faster than that is retreated
    from; one that flees may be followed at its speed. Nothing is asked without a track.

    Where the evader comes at 0.5 m/s or more and the vehicle's whole acceleration could no longer end the approach before that
    distance, it also leaves the evader's path, to the side on which it is already, else to the right: by what is missing at the
    closest approach, in half the time that is left until then.

    Not promised, because no motion can do it:
    - The distance from an evader that is faster than this vehicle, or that turns in from nearer than c^2 / (2 a) + c times the
      lag beyond the distance, at a closing speed c and the acceleration a: 3 m beyond it at 5 m/s and 5 m/s2. One that flies
      straight on is then passed as wide as the sidestep allows; one that follows it gets through.
    - The distance where fence, obstacles or teammates leave no room to retreat: those bounds weaken this one.
    - Anything beyond what the track says: a turn of the evader counts when the track shows it.
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
        keep = self._parameters.target_keep_out_m + widening
        closing = to_n * v_north + to_e * v_east - opening
        left = distance - keep - braking.reach_m(closing, context.own_age_s)
        bound = max(braking.speed_m_s(left) + opening, -context.limits.speed_max_m_s)
        if bound >= speed_m_s:
            return []
        retreat = VelocityBound(to_n, to_e, bound, self.name, "evader", distance)
        is_held_off = closing * closing <= 2.0 * context.limits.acceleration_max_m_s2 * (distance - keep)
        if is_held_off or closing <= 0.0 or -opening < COMES_M_S:
            return [retreat]
        relative = (v_north - their_north, v_east - their_east)
        beside = self._beside((to_n * distance, to_e * distance), relative, (their_north, their_east), keep, context)
        return [retreat] if beside is None else [retreat._replace(text=beside.text), beside]

    def _beside(
        self, offset: Planar, relative: Planar, theirs: Planar, keep_m: float, context: SafetyContext
    ) -> VelocityBound | None:
        """The bound that makes the closest approach `keep_m` wide; None where it is already.

        offset: to the evader, m. relative: own velocity less the evader's, m/s; not zero, and towards it.
        """
        speed = math.hypot(*relative)
        ahead_n, ahead_e = relative[0] / speed, relative[1] / speed
        along = offset[0] * ahead_n + offset[1] * ahead_e
        aside_n, aside_e = offset[0] - along * ahead_n, offset[1] - along * ahead_e
        miss = math.hypot(aside_n, aside_e)
        if miss >= keep_m:
            return None
        n, e = (aside_n / miss, aside_e / miss) if miss > ON_ITS_PATH_M else (ahead_e, -ahead_n)
        left_s = max(self._parameters.response_lag_s, HURRY * along / speed)
        away = min((keep_m - miss) / left_s, context.limits.speed_max_m_s)
        bound = max(n * theirs[0] + e * theirs[1] - away, -context.limits.speed_max_m_s)
        distance = math.hypot(*offset)
        text = f"evader {distance:.1f} m away comes too fast to be held off: retreating and leaving its path"
        return VelocityBound(n, e, bound, self.name, "evader", distance, text)
