"""What waits for the disk: bounded, and where room gets scarce the cheapest channels stay outside first. Drops are counted."""

from __future__ import annotations

import logging
import threading
from collections import Counter
from collections.abc import Mapping
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

from flightapp.recording.channels import Channel, Priority

FILL_MAX = {
    Priority.IMAGE: 0.25,
    Priority.VIEW: 0.4,
    Priority.DIAGNOSTICS: 0.55,
    Priority.SURROUNDINGS: 0.7,
    Priority.STATE: 0.85,
    Priority.ESSENTIAL: 1.0,
}
"""Share of the backlog up to which a channel is still taken: what is above is kept for what matters more."""
FREE_MIN_BYTES = {
    Priority.IMAGE: 1_000_000_000,
    Priority.VIEW: 500_000_000,
    Priority.DIAGNOSTICS: 250_000_000,
    Priority.SURROUNDINGS: 100_000_000,
    Priority.STATE: 50_000_000,
    Priority.ESSENTIAL: 0,
}
"""Free space on the disk from which on a channel is taken."""
Item = TypeVar("Item")
_LOGGER = logging.getLogger(__name__)


class Backlog(Generic[Item]):
    """Between the threads that record and the one that writes. `put` never waits.

    limit: items in all. large_limit_bytes: of large items (images) together.
    """

    def __init__(self, channels: tuple[Channel, ...], limit: int, large_limit_bytes: int) -> None:
        self._limits = {channel.topic: int(FILL_MAX[channel.priority] * limit) for channel in channels}
        self._priorities = {channel.topic: channel.priority for channel in channels}
        self._large_limit_bytes = large_limit_bytes
        self._large_waiting_bytes = 0
        self._queue: SimpleQueue[Item] = SimpleQueue()
        self._lock = threading.Lock()
        self._floor = Priority.IMAGE
        self._drops: Counter[str] = Counter()

    @property
    def dropped(self) -> int:
        """Messages that were logged and are not in the file."""
        return self._drops.total()

    @property
    def drops(self) -> Mapping[str, int]:
        """The same, by topic."""
        with self._lock:
            return dict(self._drops)

    def admits(self, topic: str) -> bool:
        """Whether there is room for one more small message of `topic`, waiting or on the disk."""
        return self._priorities[topic] >= self._floor and self._queue.qsize() < self._limits[topic]

    def put(self, item: Item) -> None:
        self._queue.put(item)

    def take(self) -> Item | None:
        """The oldest; None where nothing waits."""
        try:
            return self._queue.get_nowait()
        except Empty:
            return None

    def reserve(self, size: int) -> bool:
        """Room for one more large message, then taken. Only large messages take the lock: the control loop sends none."""
        with self._lock:
            fits = self._large_waiting_bytes + size <= self._large_limit_bytes
            if fits:
                self._large_waiting_bytes += size
        return fits

    def release(self, size: int) -> None:
        """A large message is written."""
        with self._lock:
            self._large_waiting_bytes -= size

    def drop(self, topic: str) -> None:
        with self._lock:
            self._drops[topic] += 1
            first = self._drops[topic] == 1
        if first:
            _LOGGER.warning("a message on %s could not be recorded; further drops are counted", topic)

    def note_free(self, free_bytes: int) -> None:
        """From now on only what the free space of the disk is still good for."""
        self._floor = min(priority for priority, needed in FREE_MIN_BYTES.items() if free_bytes >= needed)
