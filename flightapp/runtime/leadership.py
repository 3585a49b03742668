"""The election of a leader among the mission's pursuers, as the control loop runs it: beacons in and out, memory on disk, events.

`leader` and `term` are what this vehicle knows; only `is_leader(now_s)` is a promise, to be asked at the moment of deciding.
Without a leader nobody decides for the fleet, and each vehicle keeps what was last decided.
"""

from __future__ import annotations

from pathlib import Path

from flightapp.fleet.election.core import Election
from flightapp.fleet.election.memory import Memory, MemoryFile
from flightapp.fleet.election.timing import Timing
from flightapp.fleet.messages.election import ELECTION
from flightapp.fleet.telling import BeaconTelling
from flightapp.runtime.rooms import Rooms

BEACONS_WAITING = 4


def memory_path(run: Path, runs: Path, fleet: str, vehicle: str) -> Path:
    """Where term and vote outlast the process: the next one begins another run, where `run` is one of many in `runs`."""
    folder = runs if run.resolve().parent == runs.resolve() else run
    return folder / f"election-{fleet}-{vehicle}.json"


class Leadership:
    """Polled once a control period. A vehicle that is no pursuer takes no part."""

    def __init__(self, rooms: Rooms) -> None:
        self._rooms = rooms
        self._memory_file = MemoryFile(rooms.election_memory)
        pursuers = [vehicle.name for vehicle in rooms.mission.vehicles if vehicle.role == "pursuer"]
        self._election: Election | None = None
        if rooms.vehicle.role == "pursuer":
            self._stored = self._memory_file.load()
            self._election = Election(
                rooms.vehicle.name, pursuers, Timing(), rooms.clock.now_s(), self._stored, seed=rooms.vehicle.system_id
            )
            self._telling = BeaconTelling(rooms.team.post)
            self._inlet = rooms.team.post.inlet(ELECTION, depth=BEACONS_WAITING, addressed=True)
        self._told: tuple[str, int] | None = None
        self._complained = False

    @property
    def leader(self) -> str | None:
        """Whom this vehicle follows, or itself; None while it knows of none."""
        return None if self._election is None else self._election.leader

    @property
    def term(self) -> int:
        return 0 if self._election is None else self._election.term

    def is_leader(self, now_s: float) -> bool:
        """Whether this vehicle may decide for the fleet at `now_s`. What it decides then is to carry `term`."""
        election = self._election
        return election is not None and election.is_leader(now_s) and election.memory == self._stored

    def poll(self, now_s: float) -> None:
        """Take what was heard, answer it, and tell the journal of every change."""
        if self._election is None:
            return
        beacons = self._election.step(now_s, self._inlet.take(now_s))
        if self._remembers(self._election.memory):
            for beacon in beacons:
                self._telling.tell(beacon, now_s)
        self._tell_changes()

    def _remembers(self, memory: Memory) -> bool:
        """Whether `memory` is stored. Who cannot remember a vote says nothing: it neither votes nor leads."""
        if memory != self._stored:
            try:
                self._memory_file.store(memory)
            except OSError as error:
                if not self._complained:
                    self._complained = True
                    text = f"term and vote cannot be stored, so this vehicle takes no part in elections: {error}"
                    self._rooms.journal.event("error", "leader", text, term=memory.term)
                return False
            self._stored = memory
        return True

    def _tell_changes(self) -> None:
        """An event for every new leader, also the same one in another term, and for the loss of one."""
        before, self._told = self._told, None if self.leader is None else (self.leader, self.term)
        if self._told == before:
            return
        if self._told is None and before is not None:
            text = f"{before[0]} leads no longer, nobody yet in term {self.term}"
        else:
            text = f"{self.leader} leads in term {self.term}"
        self._rooms.journal.event("info", "leader", text, leader=self.leader, term=self.term)
