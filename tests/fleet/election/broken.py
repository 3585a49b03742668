"""Members that break one rule each: what the model and the properties must catch."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.election.core import Election
from flightapp.fleet.election.memory import Memory
from flightapp.fleet.election.timing import Timing


class VotesTwice(Election):
    def _hear(self, sender: str, beacon: Beacon, now_s: float) -> None:
        if beacon.role is Role.CANDIDATE and beacon.term == self.term and self.role is Role.FOLLOWER:
            self.memory = Memory(self.term, None)
            self._promised_to = sender
        super()._hear(sender, beacon, now_s)


class NeedsNoMajority(Election):
    def __init__(self, name: str, roster: Iterable[str], timing: Timing, now_s: float, memory: Memory | None = None) -> None:
        super().__init__(name, roster, timing, now_s, memory)
        self._majority -= 1


class BreaksPromises(Election):
    def _hear(self, sender: str, beacon: Beacon, now_s: float) -> None:
        self._promised_until_s = now_s
        super()._hear(sender, beacon, now_s)


class ForgetsItsPromiseOnRestart(Election):
    def __init__(self, name: str, roster: Iterable[str], timing: Timing, now_s: float, memory: Memory | None = None) -> None:
        super().__init__(name, roster, timing, now_s, memory)
        self._promised_until_s = now_s


class ForgetsItsTermOnRestart(Election):
    def __init__(self, name: str, roster: Iterable[str], timing: Timing, now_s: float, memory: Memory | None = None) -> None:
        super().__init__(name, roster, timing, now_s, None)


class LeadsOnWithoutAnswers(Election):
    def is_leader(self, now_s: float) -> bool:
        return self.role is Role.LEADER


class ForgetsDrift(Election):
    """Its lease is shorter than the promises, but not by what the clocks may drift."""

    def __init__(self, name: str, roster: Iterable[str], timing: Timing, now_s: float, memory: Memory | None = None) -> None:
        lease_s = 0.97 * timing.timeout_min_s
        super().__init__(name, roster, dataclasses.replace(timing, lease_s=lease_s, clock_drift_max=0.0), now_s, memory)


class ListensToOldTerms(Election):
    def _hear(self, sender: str, beacon: Beacon, now_s: float) -> None:
        if beacon.term < self.term and beacon.role is Role.LEADER:
            self.memory = Memory(beacon.term, sender)
        super()._hear(sender, beacon, now_s)
