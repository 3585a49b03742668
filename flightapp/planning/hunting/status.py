"""What is not as the hunt wants it, and for how long: told with every decision, and to the operator once it lasts."""

from __future__ import annotations

import math

from flightapp.core.types import Observation, Rendezvous
from flightapp.planning.meeting import MEETING_MIN

DEGRADED, UNREACHABLE, NO_QUORUM = "degraded", "unreachable", "no quorum"
GOAL_COVERED, BLOCKED = "goal inside an obstacle", "blocked"
TOLD_AFTER_S = 1.0
"""A flag that comes or goes for less is not told: one plan more or less is no news."""

TEXTS = {
    DEGRADED: "degraded: fewer than three on slots cannot surround the target",
    UNREACHABLE: "unreachable: the team cannot be ahead of the target in time, and cuts it off where it is least late",
    NO_QUORUM: "no quorum: too few are heard to elect a leader, so they trail the target: others may hold the ring",
    BLOCKED: "blocked: search after search has found no way to the slot",
    GOAL_COVERED: "the own slot is inside an obstacle: to the nearest free place",
}


class Status:
    """Of one hunter. It knows who takes part from what it has heard: an observation does not tell."""

    def __init__(self, encloses: bool, stale_s: float) -> None:
        """encloses: a capture needs more than one. stale_s: who was heard longer ago does not take part now."""
        self._encloses, self._stale_s = encloses, stale_s
        self.reset()

    def reset(self) -> None:
        """Forget everybody."""
        self._names: set[str] = set()
        self._was_led = False
        self._told: frozenset[str] = frozenset()
        self._since_s: tuple[float, frozenset[str]] = (-math.inf, frozenset())
        self.lacks_quorum = False

    def hear(self, observation: Observation) -> None:
        """Who is there; see `lacks_quorum`: led once, nobody leads now, and no majority of all that ever took part is heard."""
        self._names.update(member.name for member in observation.team)
        is_led = observation.assignment is not None and observation.assignment.rendezvous is not None
        self._was_led = self._was_led or is_led
        heard = 1 + sum(member.age_s <= self._stale_s for member in observation.team)
        self.lacks_quorum = self._was_led and not is_led and 2 * heard <= 1 + len(self._names)

    def flags(self, rendezvous: Rendezvous | None, *, goal_is_covered: bool, is_blocked: bool) -> list[str]:
        """As they are now."""
        is_so = {
            DEGRADED: self._encloses and rendezvous is not None and rendezvous.slots < MEETING_MIN,
            UNREACHABLE: rendezvous is not None and not rendezvous.reachable,
            NO_QUORUM: self.lacks_quorum,
            BLOCKED: is_blocked,
            GOAL_COVERED: goal_is_covered,
        }
        return [flag for flag, holds in is_so.items() if holds]

    def news(self, t_s: float, flags: list[str]) -> str:
        """What is to be said now of flags that have come or gone; empty mostly."""
        now = frozenset(flags)
        if now != self._since_s[1]:
            self._since_s = t_s, now
        if now == self._told or t_s - self._since_s[0] < TOLD_AFTER_S:
            return ""
        came, went = [TEXTS[flag] for flag in flags if flag not in self._told], sorted(self._told - now)
        self._told = now
        return "; ".join([*came, *(f"no longer: {flag}" for flag in went)])
