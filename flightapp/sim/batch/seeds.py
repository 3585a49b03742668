"""Independent random streams of one episode, equal for every planner: the same worlds and the same noise."""

from __future__ import annotations

import zlib
from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """What draws from a stream of its own."""

    LAYOUT = 0
    EVADER = 1
    SENSING = 2
    MESSAGES = 3
    WIND = 4
    TARGET = 5
    PLANNER = 6
    FAILURES = 7


def sequence(family: str, seed: int, stream: Stream) -> np.random.SeedSequence:
    """The stream of one seed of a family."""
    return np.random.SeedSequence([zlib.crc32(family.encode()), seed, int(stream)])


def key(family: str, seed: int, stream: Stream) -> int:
    """A number below 2^63 that stands for the stream."""
    return int(sequence(family, seed, stream).generate_state(1, np.uint64)[0] >> np.uint64(1))
