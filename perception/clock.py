"""Where this package reads the machine's time, for callers that bring no clock of their own: the command line is one."""

from __future__ import annotations

import time


def monotonic_s() -> float:
    """CLOCK_MONOTONIC in seconds."""
    return time.monotonic_ns() * 1e-9


def unix_s() -> float:
    """The host's Unix time in seconds; it may be stepped."""
    return time.time()
