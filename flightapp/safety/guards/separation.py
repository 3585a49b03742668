"""Distance between the vehicles of the fleet."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

from flightapp.core.types import Setpoint, TeamMember
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound, project

SIDESTEP_GAP_M = 2.0
SIDESTEP_SPEED_M_S = 1.5
HIGHER_NAME_SHARE = 0.5


class Rule(NamedTuple):
    """What one teammate asks: the bound, the gap left to the distance to keep, the own share of the sidestep."""

    bound: VelocityBound
    gap_m: float
    share: float


class SeparationGuard:
    """Specification, for each teammate within `separation_height_m` of the own height:

    - The distance to keep is `separation_min_m + separation_buffer_m`, widened by the teammate's age times its speed (its
      top speed when it is older than `team_state_age_max_s`), at most by `team_widening_max_m`.
    - The two together may close at the speed s that one of them alone can brake within the gap that is left. Each vehicle
      takes half of s. A teammate that comes faster than its half (it may not see this vehicle) takes from the own half,
      down to a retreat: the bound is s - max(s / 2, its closing speed). A stale teammate is taken to stand.
    - Keep right: what the bound takes away within 2 m of that distance is turned to the right hand, at most 1.5 m/s, and the
      speed does not grow. Both turn the same way round each other, so they pass and never mirror one another. The lower name
      gives way with all of it, the higher with half: it must also do so, because the other may stand or not know about it.
    """

    name = "separation"

    def __init__(self, parameters: SafetyParameters, names: Collection[str] | None = None) -> None:
        """Keep apart from `names`; from everyone in the team where it is None."""
        self._parameters = parameters
        self._names = None if names is None else frozenset(names)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:  # noqa: ARG002
        return [rule.bound for rule in self.rules(context) if rule.bound.bound_m_s < speed_m_s]

    def give_way(self, wish: Planar, rules: Sequence[Rule]) -> Planar:
        """`wish` with what the rules take away turned to the right hand; never faster than `wish`."""
        step_north, step_east = 0.0, 0.0
        for bound, gap_m, share in rules:
            taken = min(bound.excess_m_s(wish), bound.north * wish[0] + bound.east * wish[1], SIDESTEP_SPEED_M_S)
            if taken > 0.0:
                step = taken * share * min(1.0, max(0.0, 1.0 - gap_m / SIDESTEP_GAP_M))
                step_north -= step * bound.east
                step_east += step * bound.north
        if step_north == 0.0 and step_east == 0.0:
            return wish
        speed = math.hypot(*wish)
        north, east = project(wish, [rule.bound for rule in rules], speed)
        north, east = north + step_north, east + step_east
        scale = min(1.0, speed / max(math.hypot(north, east), 1e-12))
        return north * scale, east * scale

    def rules(self, context: SafetyContext) -> list[Rule]:
        """One rule for each teammate that counts."""
        own_north, own_east, own_down = context.own.position_ned_m.tolist()
        v_north, v_east, _ = context.own.velocity_ned_m_s.tolist()
        braking = horizontal_braking(context.limits, self._parameters)
        found = []
        for member in context.team:
            if member.name == context.name or (self._names is not None and member.name not in self._names):
                continue
            north, east, down = member.state.position_ned_m.tolist()
            their_north, their_east, _ = member.state.velocity_ned_m_s.tolist()
            if not math.isfinite(north + east + down + their_north + their_east):
                continue
            if abs(down - own_down) >= self._parameters.separation_height_m:
                continue
            lower = context.name < member.name
            to_n, to_e = north - own_north, east - own_east
            distance = math.hypot(to_n, to_e)
            to_n, to_e = (to_n / distance, to_e / distance) if distance > 1e-6 else ((-1.0, 0.0) if lower else (1.0, 0.0))
            stale = member.age_s > self._parameters.team_state_age_max_s
            gap = distance - self._keep_m(member, math.hypot(their_north, their_east), stale, context)
            theirs = 0.0 if stale else -(to_n * their_north + to_e * their_east)
            left = gap - braking.reach_m(to_n * v_north + to_e * v_east + theirs, context.own_age_s)
            together = braking.speed_m_s(left)
            bound = max(together - max(0.5 * together, theirs), -context.limits.speed_max_m_s)
            share = 1.0 if lower else HIGHER_NAME_SHARE
            found.append(Rule(VelocityBound(to_n, to_e, bound, self.name, member.name, distance), gap, share))
        return found

    def _keep_m(self, member: TeamMember, speed_m_s: float, stale: bool, context: SafetyContext) -> float:
        speed = max(speed_m_s, context.limits.speed_max_m_s) if stale else speed_m_s
        widening = min(self._parameters.team_widening_max_m, max(0.0, member.age_s) * speed)
        return self._parameters.separation_min_m + self._parameters.separation_buffer_m + widening
