"""Pursuers that fail in flight: when each is due, and who it is."""

from __future__ import annotations

from collections.abc import Callable

from flightapp.sim.batch.noise import uniform
from flightapp.sim.batch.scenario import Failure, Scenario

DUE_S = 1e-9


class Failing:
    """Which pursuers live. Who "random" is follows from the seed; "leader" is whoever leads then, or the next one to lead."""

    def __init__(self, scenario: Scenario, key: int) -> None:
        self.alive = [True] * scenario.pursuers.count
        self._key = key
        self._pending = sorted(enumerate(scenario.failures), key=lambda each: each[1].t_s)

    def step(self, t_s: float, leader: Callable[[], int | None]) -> list[int]:
        """The pursuers that fail at `t_s`."""
        failed: list[int] = []
        later: list[tuple[int, Failure]] = []
        for number, failure in self._pending:
            index = self._named(number, failure, leader) if t_s >= failure.t_s - DUE_S else None
            if index is None:
                later.append((number, failure))
            elif self.alive[index]:
                self.alive[index] = False
                failed.append(index)
        self._pending = later
        return failed

    def _named(self, number: int, failure: Failure, leader: Callable[[], int | None]) -> int | None:
        """None: nobody that it can be now."""
        if failure.vehicle == "leader":
            return leader()
        if failure.vehicle != "random":
            return int(failure.vehicle[1:]) - 1
        leads = leader()
        others = [i for i, living in enumerate(self.alive) if living and i != leads]
        return others[int(uniform(self._key, number, 0, 0) * len(others))] if others else None
