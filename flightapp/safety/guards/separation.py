"""Distance between the vehicles of the fleet."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from flightapp.core.clearance import miss_m
from flightapp.core.types import Array, Setpoint, TeamMember
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.escape import Escape, Rule
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound, project

TANGENT_SHARES = (0.0, -1.0, 1.0)
ACTUAL_WEIGHT = 20.0
"""How much more the actual velocity counts than the wanted one in the choice of a line, as for obstacles."""
SIDESTEP_GAP_M = 2.0
SIDESTEP_SPEED_M_S = 1.5
HIGHER_NAME_SHARE = 0.5


class SeparationGuard:
    """Specification, for each teammate within `separation_height_m` of the own height:

    - The distance to keep is `separation_min_m + separation_buffer_m`, widened by the teammate's age times its speed (its
      top speed when it is older than `team_state_age_max_s`), at most by `team_widening_max_m`.
    - A teammate that both the actual and the wanted velocity pass, by the shared rule `miss_m`, at that distance and
      `separation_passing_m` more asks nothing while it is fresh.
    - Otherwise there is a line between the two, across the line of sight or touching the circle of the distance to keep
      around the teammate. Towards it the two together may close at the speed s that one of them alone can brake within the
      gap that is left. Of the lines the one is taken that the actual and the wanted velocity break least, the actual one
      counting more: a pass that gets narrow is widened and not braked. Each vehicle takes half of s. A teammate that
      comes faster than its half (it may not see this vehicle) takes from the own half, down to a retreat: the bound is
      s - max(s / 2, its closing speed). A stale teammate is taken to stand, behind a line across the line of sight.
    - Keep right: what the bound takes away within 2 m of that distance is turned to the right hand, at most 1.5 m/s, and the
      speed does not grow. Both turn the same way round each other, so they pass and never mirror one another. The lower name
      gives way with all of it, the higher with half: it must also do so, because the other may stand or not know about it.
    - Where there is no room to pass that way, `Escape` makes one of the two yield, the lower name first.

    Not promised: the distance from a vehicle that hunts this one as fast as it can fly, when this one alone gives way.
    """

    name = "separation"

    def __init__(self, parameters: SafetyParameters, names: Collection[str] | None = None) -> None:
        """Keep apart from `names`; from everyone in the team where it is None."""
        self._parameters = parameters
        self._names = None if names is None else frozenset(names)
        self._escape = Escape()

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:
        return [rule.bound for rule in self.rules(wish, context) if rule.bound.bound_m_s < speed_m_s]

    def give_way(self, wish: Planar, rules: Sequence[Rule]) -> Planar:
        """`wish` with what the rules take away turned to the right hand; never faster than `wish`."""
        step_north, step_east = 0.0, 0.0
        for bound, gap_m, share in rules:
            taken = min(bound.excess_m_s(wish), bound.north * wish[0] + bound.east * wish[1], SIDESTEP_SPEED_M_S)
            if taken > 0.0:
                step = taken * share * min(1.0, max(0.0, 1.0 - gap_m / SIDESTEP_GAP_M)) * self._escape.hand(bound.what)
                step_north -= step * bound.east
                step_east += step * bound.north
        if step_north == 0.0 and step_east == 0.0:
            return wish
        speed = math.hypot(*wish)
        north, east = project(wish, [rule.bound for rule in rules], speed)
        for bound, _, _ in rules:
            rightwards = north * -bound.east + east * bound.north
            if self._escape.hand(bound.what) < 0.0 and rightwards > 0.0:
                north, east = north + rightwards * bound.east, east - rightwards * bound.north
        north, east = north + step_north, east + step_east
        scale = min(1.0, speed / max(math.hypot(north, east), 1e-12))
        return north * scale, east * scale

    def escape(self, wish: Planar, rules: Sequence[Rule], context: SafetyContext) -> Planar | None:
        """The velocity at which to back off, where this vehicle is the one to yield; to be called once a period."""
        return self._escape.velocity(wish, rules, context)

    def rules(self, wish: Planar, context: SafetyContext) -> list[Rule]:
        """One rule for each teammate that counts for a vehicle that wants to fly at `wish` (m/s)."""
        own_north, own_east, own_down = context.own.position_ned_m.tolist()
        found = []
        for member in context.team:
            if member.name == context.name or (self._names is not None and member.name not in self._names):
                continue
            north, east, down = member.state.position_ned_m.tolist()
            if not math.isfinite(north + east + down + float(member.state.velocity_ned_m_s[:2].sum())):
                continue
            if abs(down - own_down) >= self._parameters.separation_height_m:
                continue
            rule = self._rule(member, (north - own_north, east - own_east), wish, context)
            if rule is not None:
                found.append(rule)
        return found

    def _rule(self, member: TeamMember, offset: Planar, wish: Planar, context: SafetyContext) -> Rule | None:
        own, theirs = _planar(context.own.velocity_ned_m_s), _planar(member.state.velocity_ned_m_s)
        stale = member.age_s > self._parameters.team_state_age_max_s
        keep = self._keep_m(member, math.hypot(*theirs), stale, context)
        passing = keep + self._parameters.separation_passing_m
        if not stale and min(miss_m(offset, _less(own, theirs)), miss_m(offset, _less(wish, theirs))) >= passing:
            return None
        braking = horizontal_braking(context.limits, self._parameters)
        lower = context.name < member.name
        distance = math.hypot(*offset)
        to_n, to_e = (offset[0] / distance, offset[1] / distance) if distance > 1e-6 else ((-1.0, 0.0) if lower else (1.0, 0.0))
        widest = math.acos(min(1.0, keep / max(distance, keep)))
        best, least = None, math.inf
        straight = stale or widest == 0.0 or self._escape.is_narrow(member.name)
        for side in (0.0,) if straight else TANGENT_SHARES:
            cosine, sine = math.cos(side * widest), math.sin(side * widest)
            n, e = to_n * cosine - to_e * sine, to_n * sine + to_e * cosine
            gap = distance * cosine - keep
            coming = 0.0 if stale else -(n * theirs[0] + e * theirs[1])
            closing = n * own[0] + e * own[1]
            together = braking.speed_m_s(gap - braking.reach_m(closing + coming, context.own_age_s))
            bound = max(together - max(0.5 * together, coming), -context.limits.speed_max_m_s)
            excess = max(n * wish[0] + e * wish[1] - bound, ACTUAL_WEIGHT * (closing - bound))
            if excess < least:
                best, least = VelocityBound(n, e, bound, self.name, member.name, distance), excess
        return None if best is None else Rule(best, distance - keep, 1.0 if lower else HIGHER_NAME_SHARE)

    def _keep_m(self, member: TeamMember, speed_m_s: float, stale: bool, context: SafetyContext) -> float:
        speed = max(speed_m_s, context.limits.speed_max_m_s) if stale else speed_m_s
        widening = min(self._parameters.team_widening_max_m, max(0.0, member.age_s) * speed)
        return self._parameters.separation_min_m + self._parameters.separation_buffer_m + widening


def _planar(velocity: Array) -> Planar:
    return float(velocity[0]), float(velocity[1])


def _less(one: Planar, other: Planar) -> Planar:
    return one[0] - other[0], one[1] - other[1]
