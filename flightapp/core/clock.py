"""The only module that reads the system's time.

Fleet time is Unix time carried by the monotonic clock: comparable between vehicles (after correction by the measured
offset) and never stepping backwards while the process lives.
"""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import Protocol


class Clock(Protocol):
    """Source of fleet time in seconds."""

    def now_s(self) -> float: ...


class SystemClock:
    """Fleet time from CLOCK_MONOTONIC plus the Unix offset measured once at creation."""

    def __init__(self) -> None:
        before = time.monotonic_ns()
        unix_ns = time.time_ns()
        after = time.monotonic_ns()
        self._offset_ns = unix_ns - (before + after) // 2

    def now_s(self) -> float:
        return (time.monotonic_ns() + self._offset_ns) * 1e-9

    def now_ns(self) -> int:
        """Fleet time in integer nanoseconds, for recordings."""
        return time.monotonic_ns() + self._offset_ns

    def unix_s(self) -> float:
        """The system's own clock now, for stamps that a driver took from it; it may have been stepped since the start."""
        return time.time()

    def from_monotonic_ns(self, monotonic_ns: int) -> float:
        """Fleet time in seconds of a CLOCK_MONOTONIC stamp taken on this machine, by any process."""
        return (monotonic_ns + self._offset_ns) * 1e-9


class ManualClock:
    """A clock that a test or a faster-than-real-time simulation moves by hand."""

    def __init__(self, t_s: float = 0.0) -> None:
        self.t_s = t_s

    def now_s(self) -> float:
        return self.t_s

    def advance(self, dt_s: float) -> None:
        self.t_s += dt_s


def thread_ns() -> int:
    """Processor time of this thread: what it computed, without the turns that others had meanwhile."""
    return time.thread_time_ns()


def monotonic_ns() -> int:
    """CLOCK_MONOTONIC, shared by all processes of one machine: for stamps that cross a process border, and for time spent."""
    return time.monotonic_ns()


def thread_cpu_ns() -> int:
    """CPU time of the calling thread: what work costs, whatever else the machine does."""
    return time.thread_time_ns()


def utc_stamp() -> str:
    """Wall-clock time for names of files and folders: 20260601-101500, UTC."""
    return f"{datetime.now(UTC):%Y%m%d-%H%M%S}"
