"""Single-slot mailbox: the newest value wins, nothing queues."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")


class Stamped(NamedTuple, Generic[T]):
    """A value and the fleet time at which it arrived here."""

    value: T
    arrived_s: float


class Latest(Generic[T]):
    """Latest-value slot. `put` is one reference assignment, safe from any thread."""

    __slots__ = ("_item", "received")

    def __init__(self) -> None:
        self._item: Stamped[T] | None = None
        self.received = 0

    def put(self, value: T, arrived_s: float) -> None:
        self._item = Stamped(value, arrived_s)
        self.received += 1

    def get(self) -> Stamped[T] | None:
        return self._item

    def age_s(self, now_s: float) -> float:
        """Seconds since the last arrival; infinite before the first."""
        item = self._item
        return float("inf") if item is None else now_s - item.arrived_s
