"""The state machine that obeys the failsafe table. Knows no condition by name; no clock, no I/O."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from flightapp.safety.failsafe.table import TABLE, WISHES, Condition, Row, State

RELEASE_S = 1.0
"""A HOLD or DEGRADED ends when nothing has asked for it for this long: no flapping."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """The state, the row that put the vehicle into it (None in NORMAL), and whether that happened in this step."""

    state: State
    row: Row | None
    is_new: bool


class Failsafe:
    """One instance a vehicle; `step` once a control period.

    - Of the rows in effect the most severe action wins, the first in the table of equals.
    - RETURN, LAND and TERMINATE are kept: a vehicle on its way down does not turn round when a link comes back. They give way
      to more severe ones only.
    - PILOT is kept too. A row that the pilot may not override breaks it, and so does a wish of a person (the conditions in
      `wishes`) that is newer than the takeover. Between persons the newest word counts: a takeover that is older than the
      wish is over, a newer one wins again.
    """

    def __init__(self, rows: Sequence[Row] = TABLE, wishes: Collection[Condition] = WISHES) -> None:
        self._rows = tuple(rows)
        self._wishes = frozenset(wishes)
        self._since_s: dict[Condition, float] = {}
        self._state = State.NORMAL
        self._row: Row | None = None
        self._entered_s = -math.inf
        self._asked_s = -math.inf
        self._overruled_s = -math.inf
        """When a person's wish last ended PILOT."""

    @property
    def state(self) -> State:
        return self._state

    def step(self, t_s: float, active: Collection[Condition]) -> Verdict:
        """`active`: the conditions that hold at `t_s`."""
        self._since_s = {condition: self._since_s.get(condition, t_s) for condition in active}
        row = max(self._counting(self.in_effect(t_s)), key=lambda row: row.action, default=None)
        state = State.NORMAL if row is None else row.action
        if state >= self._state:
            self._asked_s = t_s
        if state == self._state or not self._may_enter(state, t_s):
            return Verdict(self._state, self._row, is_new=False)
        if self._state is State.PILOT:
            self._overruled_s = t_s
        self._state, self._row, self._entered_s = state, row, t_s
        return Verdict(state, row, is_new=True)

    def renew(self, condition: Condition) -> None:
        """A person asks again: from now on `condition` counts as new."""
        self._since_s.pop(condition, None)

    def in_effect(self, t_s: float) -> list[Row]:
        """The rows whose condition has lasted long enough, in the table's order."""
        return [row for row in self._rows if t_s - self._since_s.get(row.condition, math.inf) >= row.delay_s]

    def _counting(self, rows: list[Row]) -> list[Row]:
        """Of `rows` those that count between a pilot and the others: what nobody overrides, then the newest word of a person."""
        forced = [row for row in rows if not row.pilot_may_override]
        if forced:
            return forced
        if self._state is not State.PILOT:
            return [row for row in rows if row.action is not State.PILOT or self._since_s[row.condition] > self._overruled_s]
        wished = [row for row in rows if row.condition in self._wishes and self._since_s[row.condition] > self._entered_s]
        return wished or [row for row in rows if row.action is State.PILOT]

    def _may_enter(self, state: State, t_s: float) -> bool:
        if self._state is State.PILOT:
            return state is not State.NORMAL
        if self._state > State.HOLD:
            return state > self._state
        return state > self._state or t_s - self._asked_s >= RELEASE_S
