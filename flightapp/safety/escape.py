"""Who yields when two vehicles block each other: the fixed order that ends every stand-off."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from flightapp.safety.api import SafetyContext
from flightapp.safety.duration import Duration
from flightapp.safety.velocity_bounds import Planar, VelocityBound

BLOCKED_SPEED_M_S = 0.4
BLOCKED_EXCESS_M_S = 0.5
BLOCKED_GAP_M = 6.0
LOWER_YIELDS_AFTER_S, HIGHER_YIELDS_AFTER_S = 2.0, 10.0
BACKING_OFF_S = 8.0
BACKING_OFF_M_S = 1.0
STANDS_WITHIN_M = 1.0
FORGOTTEN_BEYOND_M = 10.0


class Rule(NamedTuple):
    """What one teammate asks: the bound, the gap left to the distance to keep, the own share of the sidestep."""

    bound: VelocityBound
    gap_m: float
    share: float


class Encounter:
    """One teammate that was in the way: for how long both stand, how long this vehicle still backs off, and the hand it keeps."""

    def __init__(self) -> None:
        self.blocked = Duration()
        self.left_s = 0.0
        self.hand = 1.0
        self.theirs_m = (0.0, 0.0)
        self.is_narrow = False


class Escape:
    """Specification. Two vehicles are blocked when both stand (below 0.4 m/s) within 2 m of the distance to keep and this one
    wants to close in by 0.5 m/s more than it may.

    - After 2 s of that the lower name backs off against its own wish, at 1 m/s for 8 s, and the higher follows: out of a
      corridor that is too narrow to pass. Where the lower has nowhere to go, the higher does the same after 10 s.
    - A teammate that has not moved by 1 m meanwhile stands for good: it is then passed on the other hand, and so in turn.

    Backing off is a wish: fence, obstacles and all other teammates bound it as any other. It is never faster than the wish.
    """

    def __init__(self) -> None:
        self._encounters: dict[str, Encounter] = {}

    def hand(self, name: str) -> float:
        """1.0 to pass the teammate on the right hand, -1.0 on the left."""
        return self._encounters[name].hand if name in self._encounters else 1.0

    def is_narrow(self, name: str) -> bool:
        """True once this vehicle and the teammate have blocked each other: there is no room for a line beside it."""
        return name in self._encounters and self._encounters[name].is_narrow

    def velocity(self, wish: Planar, rules: Sequence[Rule], context: SafetyContext) -> Planar | None:
        """Planar velocity m/s at which to back off from whoever blocks the way, None where nobody does; once a period."""
        self._forget(context)
        states = {member.name: member.state for member in context.team}
        backs_off = False
        for bound, gap_m, _ in rules:
            met = self._encounters.setdefault(bound.what, Encounter())
            theirs = states[bound.what]
            stands = (
                max(_speed(context.own.velocity_ned_m_s.tolist()), _speed(theirs.velocity_ned_m_s.tolist())) < BLOCKED_SPEED_M_S
            )
            is_blocked = stands and gap_m < BLOCKED_GAP_M and bound.excess_m_s(wish) > BLOCKED_EXCESS_M_S
            lasted_s = met.blocked.of(is_blocked and met.left_s <= 0.0, context.dt_s)
            met.is_narrow |= lasted_s >= LOWER_YIELDS_AFTER_S
            place = (float(theirs.position_ned_m[0]), float(theirs.position_ned_m[1]))
            if lasted_s >= (LOWER_YIELDS_AFTER_S if context.name < bound.what else HIGHER_YIELDS_AFTER_S):
                met.left_s, met.theirs_m = BACKING_OFF_S, place
            elif met.left_s > 0.0:
                met.left_s -= context.dt_s
                if met.left_s <= 0.0 and math.dist(place, met.theirs_m) < STANDS_WITHIN_M:
                    met.hand = -met.hand
            backs_off |= met.left_s > 0.0
        speed = math.hypot(*wish)
        if not backs_off or speed == 0.0:
            return None
        scale = -min(1.0, BACKING_OFF_M_S / speed)
        return wish[0] * scale, wish[1] * scale

    def _forget(self, context: SafetyContext) -> None:
        if not self._encounters:
            return
        near = {
            member.name
            for member in context.team
            if _speed((member.state.position_ned_m - context.own.position_ned_m).tolist()) < FORGOTTEN_BEYOND_M
        }
        self._encounters = {name: met for name, met in self._encounters.items() if name in near}


def _speed(vector: Sequence[float]) -> float:
    """Length of the planar part."""
    return math.hypot(vector[0], vector[1])
