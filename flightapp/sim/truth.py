"""True state of one simulated vehicle, shared between the processes of one machine through a memory-mapped file.

One writer (the mock autopilot), any number of readers (camera, referee). A sequence number that is odd while the writer
writes lets a reader detect a torn read and try again; no locks, no queue, the newest state wins.
"""

from __future__ import annotations

import mmap
import struct
from dataclasses import dataclass
from pathlib import Path

_SEQUENCE = struct.Struct("<Q")
_STATE = struct.Struct("<q9d2?")
_SIZE = 128
_ATTEMPTS = 100


@dataclass(frozen=True, slots=True)
class Truth:
    """True state at `monotonic_ns` (CLOCK_MONOTONIC): position and velocity NED in the mission frame, attitude in rad."""

    monotonic_ns: int
    position_ned_m: tuple[float, float, float]
    velocity_ned_m_s: tuple[float, float, float]
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    armed: bool
    on_ground: bool


class TruthWriter:
    """Creates the file and overwrites the state in place."""

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(_SIZE))
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), _SIZE)
        self._sequence = 0

    def write(self, truth: Truth) -> None:
        self._sequence += 1
        _SEQUENCE.pack_into(self._map, 0, self._sequence)
        _STATE.pack_into(
            self._map,
            8,
            truth.monotonic_ns,
            *truth.position_ned_m,
            *truth.velocity_ned_m_s,
            truth.roll_rad,
            truth.pitch_rad,
            truth.yaw_rad,
            truth.armed,
            truth.on_ground,
        )
        self._sequence += 1
        _SEQUENCE.pack_into(self._map, 0, self._sequence)

    def close(self) -> None:
        self._map.close()


class TruthReader:
    """Reads the newest state; None until the writer has written one.

    Where the writer was interrupted in the middle of a write, the last good state is returned again.
    """

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            self._map = mmap.mmap(file.fileno(), _SIZE, access=mmap.ACCESS_READ)
        self._last: Truth | None = None

    def read(self) -> Truth | None:
        for _ in range(_ATTEMPTS):
            (before,) = _SEQUENCE.unpack_from(self._map, 0)
            values = _STATE.unpack_from(self._map, 8)
            (after,) = _SEQUENCE.unpack_from(self._map, 0)
            if before == after and before % 2 == 0:
                break
        else:
            return self._last
        if before == 0:
            return None
        self._last = Truth(values[0], values[1:4], values[4:7], values[7], values[8], values[9], values[10], values[11])
        return self._last

    def close(self) -> None:
        self._map.close()
