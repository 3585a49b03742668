"""What a member of the roster tells all others. One beacon says everything: the newest replaces all older ones."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Role(IntEnum):
    """What a member does at present. The numbers travel."""

    FOLLOWER = 0
    SEEKING = 1
    """Asks whether a majority misses a leader as well, and changes nothing by that (pre-vote)."""
    CANDIDATE = 2
    """Asks for votes in a term of its own."""
    LEADER = 3


@dataclass(frozen=True, slots=True)
class Beacon:
    """A member's standing."""

    stamp_s: float
    """Send time on the sender's own clock: it means something to the sender alone, who gets it back in `backs`."""
    term: int
    role: Role
    backs: tuple[tuple[str, float], ...] = ()
    """Whom the sender backs in this term, with the newest stamp it has heard of each: the leader that it follows, the candidate
    that it voted for, or everyone seeking whom it would vote for."""
