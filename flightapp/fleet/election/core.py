"""Leader election by terms: Raft's, without a log, with pre-vote and leases, said by beacons instead of calls.

Ongaro and Ousterhout, In Search of an Understandable Consensus Algorithm, 2014, section 5.2; Ongaro, Consensus: Bridging Theory
and Practice, 2014, sections 6.4.1 (leases) and 9.6 (pre-vote). The rules, and what each is for:

1. A member votes once in a term, and remembers term and vote over a restart: at most one leader a term.
2. A higher term is adopted at once, a lower one is not listened to: terms never go back, a leader that returns steps down.
3. Who hears a leader, or votes for one, promises not to back anybody else for `timeout_min_s`; so does who has just started, for
   it may have promised. A leader leads only for `lease_s` since it sent what a majority has answered. `Timing` makes every lease
   shorter than every promise, whatever clocks drift: a new leader's majority contains somebody whose promise had ended, so the
   old leader's lease had ended before. A leader without majority leads nobody.
4. A new term is begun only by who knows that a majority misses a leader too (SEEKING): a member that comes and goes, or hears
   badly, raises no terms and deposes nobody.
5. Timeouts differ by the place in the roster, which rotates with the term, and by a part drawn from the seed; of several who are
   SEEKING the first goes first: ties are rare and do not repeat.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from random import Random

from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.election.memory import Memory
from flightapp.fleet.election.timing import Timing

PERIODS = {Role.FOLLOWER: 2.0, Role.SEEKING: 0.5, Role.CANDIDATE: 0.5, Role.LEADER: 1.0}
"""Between two beacons. A follower answers whenever it is asked and rarely speaks by itself; an election is in a hurry."""
GIVEN_WAY_PERIODS = 2.0
"""A candidate is heard of within so many beacon periods of its first backing."""
CANDIDATES_SPREAD = 3.0
"""How much further apart candidates give up than followers lose patience: the next to ask must be heard before the other asks."""


class Election:
    """One member's part. Deterministic; `now_s` of every call is the own clock's and never decreases, its offset is free.

    Whatever changes `memory` must be stored before what `step` returned is sent.
    """

    def __init__(
        self, name: str, roster: Iterable[str], timing: Timing, now_s: float, memory: Memory | None = None, seed: int = 0
    ) -> None:
        """roster: all configured members, the own name among them; the same on all. memory: what an earlier life stored."""
        self.name = name
        self._roster = tuple(sorted(set(roster)))
        if name not in self._roster:
            raise ValueError(f"'{name}' is not in the roster {', '.join(self._roster)}")
        self._majority = len(self._roster) // 2 + 1
        self._timing = timing
        self._seed = seed
        self.memory = Memory() if memory is None else memory
        self.role = Role.FOLLOWER
        self.leader: str | None = None
        """Whom this member follows, or itself; None while there is none."""
        self._promised_to: str | None = None
        self._promised_until_s = now_s + timing.timeout_min_s
        self._patient_until_s = now_s + self._timeout_s()
        """Never before the promise has ended."""
        self._asking_since_s = now_s
        self._backs: Mapping[str, float] = {}
        self._backers: Mapping[str, float] = {}
        """Who backs this member, with the newest of its stamps that each has heard."""
        self._beacon_due_s = now_s

    @property
    def term(self) -> int:
        return self.memory.term

    def is_leader(self, now_s: float) -> bool:
        """Whether this member may speak for the fleet at `now_s`: to be asked at the time of speaking."""
        return self.role is Role.LEADER and self._is_backed(now_s)

    def step(self, now_s: float, inbox: Iterable[tuple[str, Beacon]]) -> tuple[Beacon, ...]:
        """Take what was heard, (sender, beacon) each, and let time pass; what is to be told to all others."""
        before = self.memory, self.role
        asked = False
        for sender, beacon in inbox:
            if sender in self._roster and sender != self.name:
                self._hear(sender, beacon, now_s)
                asked |= beacon.role is not Role.FOLLOWER
        self._decide(now_s)
        answers = asked and self.role is Role.FOLLOWER
        if not answers and (self.memory, self.role) == before and now_s < self._beacon_due_s:
            return ()
        self._beacon_due_s = now_s + PERIODS[self.role] * self._timing.beacon_period_s
        return (Beacon(now_s, self.term, self.role, tuple(self._backs.items())),)

    def _hear(self, sender: str, beacon: Beacon, now_s: float) -> None:
        if beacon.term > self.term:
            self._adopt(beacon.term, now_s)
        if beacon.term < self.term:
            return
        for name, stamp_s in beacon.backs:
            if name == self.name and self._asking_since_s <= stamp_s <= now_s:
                self._backers = {**self._backers, sender: max(stamp_s, self._backers.get(sender, stamp_s))}
        is_free = self._promised_to == sender or now_s >= self._promised_until_s
        if beacon.role is Role.LEADER:
            self._follow(sender, beacon, now_s)
            self.leader = sender
        elif beacon.role is Role.CANDIDATE and is_free and self.memory.vote in (None, sender):
            self.memory = Memory(self.term, sender)
            self._follow(sender, beacon, now_s)
        elif beacon.role is Role.SEEKING and is_free and self.role is not Role.LEADER:
            self._backs = {**self._backs, sender: beacon.stamp_s}

    def _decide(self, now_s: float) -> None:
        if self.role is Role.LEADER and not self._is_backed(now_s):
            self._become(Role.FOLLOWER, now_s, self._timeout_s())
        elif self.role is Role.SEEKING and self._is_backed(now_s) and self._has_given_way(now_s):
            self.memory = Memory(self.term + 1, self.name)
            self._become(Role.CANDIDATE, now_s, self._timeout_s(CANDIDATES_SPREAD))
        elif self.role in (Role.FOLLOWER, Role.CANDIDATE) and now_s >= self._patient_until_s:
            self._become(Role.SEEKING, now_s, math.inf)
        if self.role is Role.CANDIDATE and self._is_backed(now_s):
            self.role, self.leader = Role.LEADER, self.name

    def _follow(self, sender: str, beacon: Beacon, now_s: float) -> None:
        """Back `sender` alone, and promise it."""
        self.role, self.leader = Role.FOLLOWER, None
        self._backs, self._backers = {sender: beacon.stamp_s}, {}
        self._promised_to = sender
        self._promised_until_s = now_s + self._timing.timeout_min_s
        self._patient_until_s = now_s + self._timeout_s()

    def _adopt(self, term: int, now_s: float) -> None:
        """Enter a term that others have begun. A promise made in an earlier one stands."""
        self.memory = Memory(term, None)
        patient_until_s = self._patient_until_s if self.role is Role.FOLLOWER else math.inf
        self._become(Role.FOLLOWER, now_s, self._timeout_s())
        self._patient_until_s = min(patient_until_s, self._patient_until_s)

    def _become(self, role: Role, now_s: float, patience_s: float) -> None:
        """Start afresh in `role`, backed by nobody but oneself."""
        self.role, self.leader = role, None
        self._backs, self._backers = {}, {}
        self._asking_since_s = now_s
        self._patient_until_s = now_s + patience_s

    def _is_backed(self, now_s: float) -> bool:
        """Whether a majority, oneself included, has lately answered: the answers to one's stamps reach back less than a lease."""
        stamps_s = sorted((math.inf, *self._backers.values()), reverse=True)
        return len(stamps_s) >= self._majority and now_s < stamps_s[self._majority - 1] + self._timing.lease_s

    def _has_given_way(self, now_s: float) -> bool:
        """Whether those who seek as well and come first in this term have had their time: they may be heard, but hear nobody."""
        ahead = sum(self._slot(name) < self._slot(self.name) for name in self._backs)
        return now_s >= self._asking_since_s + ahead * GIVEN_WAY_PERIODS * self._timing.beacon_period_s

    def _slot(self, name: str) -> int:
        """The order among the roster in this term."""
        return (self._roster.index(name) + self.term) % len(self._roster)

    def _timeout_s(self, spread: float = 1.0) -> float:
        """The same for the same member and term."""
        part = (self._slot(self.name) + Random(f"{self._seed} {self.name} {self.term}").random()) / len(self._roster)
        return self._timing.timeout_min_s + spread * part * (self._timing.timeout_max_s - self._timing.timeout_min_s)
