"""What changed from one look at the fleet to the next, in one sentence each."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.watch.data_model_leader import Leadership
from flightapp.watch.data_model_rows import SHAPING, Link, Row


@dataclass(frozen=True, slots=True)
class Event:
    """`t_s`: when it was noticed here."""

    t_s: float
    text: str


class EventWatch:
    """Remembers the last look."""

    def __init__(self) -> None:
        self._rows: dict[str, Row] = {}
        self._leader: str | None = None
        self._term = 0

    def changes(self, now_s: float, rows: tuple[Row, ...], leadership: Leadership) -> list[Event]:
        """Since the last call."""
        texts = [text for row in rows for text in _changes_of(self._rows.get(row.name), row)]
        if (leadership.leader, leadership.term) != (self._leader, self._term):
            if leadership.leader is not None:
                texts.append(f"{leadership.leader} leads in term {leadership.term}")
            elif self._leader is not None:
                texts.append(f"{self._leader} leads no longer")
        self._rows = {row.name: row for row in rows}
        self._leader, self._term = leadership.leader, leadership.term
        return [Event(now_s, text) for text in texts]


def _changes_of(before: Row | None, after: Row) -> list[str]:
    state = after.state
    if state is None:
        return []
    if before is None or before.state is None:
        return [f"{after.name} is heard, in phase {state.phase}"]
    texts = []
    if after.link is Link.LOST and before.link is not Link.LOST:
        texts.append(f"{after.name} is silent")
    if before.link is Link.LOST and after.link in (Link.FRESH, Link.LATE):
        texts.append(f"{after.name} is heard again")
    if before.state.phase != state.phase:
        texts.append(f"{after.name}: {before.state.phase} -> {state.phase}")
    if state.outcome is not None and before.state.outcome != state.outcome:
        texts.append(f"{after.name}: {state.outcome}")
    known = {guard for guard, _ in before.guards}
    begun = [guard for guard, acting_s in after.guards if guard not in known and acting_s == 0.0 and guard not in SHAPING]
    texts += [f"{after.name}: guard {guard} acts" for guard in begun]
    return texts
