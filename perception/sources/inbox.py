"""One place for one frame between the camera's thread, which delivers, and the thread that polls."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

_WAIT_S = 0.1


@dataclass(frozen=True, slots=True)
class Arrival:
    """A delivered frame, still the driver's, and when it was taken (caller's time)."""

    frame: Any
    number: int
    t_s: float


class Inbox:
    """The newest frame wins; with `is_lossless` (a recording read as fast as it can be) delivery waits until it was taken."""

    def __init__(self, *, is_lossless: bool) -> None:
        self._changed = threading.Condition()
        self._is_lossless = is_lossless
        self._is_closed = False
        self._waiting: Arrival | None = None
        self._number: int | None = None
        self.skipped = 0
        self.lost = 0
        self.arrived = 0

    def put(self, arrival: Arrival) -> None:
        with self._changed:
            while self._is_lossless and self._waiting is not None and not self._is_closed:
                self._changed.wait(_WAIT_S)
            if self._is_closed:
                return
            self.skipped += self._waiting is not None
            # A number that does not rise is a camera that counts anew, not a loss.
            if self._number is not None and arrival.number > self._number:
                self.lost += arrival.number - self._number - 1
            self._number = arrival.number
            self._waiting = arrival
            self.arrived += 1

    def take(self) -> Arrival | None:
        """The waiting frame, once."""
        with self._changed:
            arrival, self._waiting = self._waiting, None
            self._changed.notify()
            return arrival

    def forget_number(self) -> None:
        """The camera is started again: its next number says nothing of losses."""
        with self._changed:
            self._number = None

    def close(self) -> None:
        """Whoever waits to deliver goes on; later frames are dropped."""
        with self._changed:
            self._is_closed = True
            self._waiting = None
            self._changed.notify_all()
