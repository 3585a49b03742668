"""Depth frames through a memory-mapped file: one writer process, any number of reader processes, the newest frame wins.

Layout, little endian: a header (magic, width, height, depth unit, intrinsics, number of the newest frame), then three slots
of (sequence, frame number, capture time on CLOCK_MONOTONIC in ns, pixels). Frame k lies in slot k mod 3. A slot's sequence is
odd while it is written, so that a reader that was overtaken notices and reads the newer frame instead. No locks, no queue.
"""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from perception.sources.api import SourceHealth
from perception.types import DepthFrame, Intrinsics

_MAGIC = b"DEPTHV01"
_HEADER = struct.Struct("<8sqqddddd")
_NEWEST = struct.Struct("<q")
_NEWEST_AT = 120
_HEADER_SIZE = 128
_SLOT_HEADER = struct.Struct("<Qqq")
_SEQUENCE = struct.Struct("<Q")
_SLOT_HEADER_SIZE = 64
_SLOTS = 3
_ATTEMPTS = 10


def _slot_size(width_px: int, height_px: int) -> int:
    return _SLOT_HEADER_SIZE + (2 * width_px * height_px + 63) // 64 * 64


class SharedMemoryWriter:
    """Creates the file (replacing an old one) and publishes frames into it."""

    def __init__(self, path: Path, intrinsics: Intrinsics, depth_unit_m: float = 0.001) -> None:
        self._shape = (intrinsics.height_px, intrinsics.width_px)
        self._slot_size = _slot_size(intrinsics.width_px, intrinsics.height_px)
        size = _HEADER_SIZE + _SLOTS * self._slot_size
        new = path.with_name(path.name + ".new")
        with new.open("w+b") as file:
            file.truncate(size)
            self._map = mmap.mmap(file.fileno(), size)
        _HEADER.pack_into(
            self._map,
            0,
            _MAGIC,
            intrinsics.width_px,
            intrinsics.height_px,
            depth_unit_m,
            intrinsics.fx_px,
            intrinsics.fy_px,
            intrinsics.cx_px,
            intrinsics.cy_px,
        )
        os.replace(new, path)
        self._number = 0
        self._sequences = [0] * _SLOTS

    def write(self, depth: NDArray[np.uint16], captured_monotonic_ns: int) -> int:
        """Publish one (height, width) image; returns its number, counted from 1."""
        if depth.shape != self._shape:
            raise ValueError(f"depth image of shape {depth.shape}: the file was made for {self._shape}")
        number = self._number + 1
        slot = number % _SLOTS
        at = _HEADER_SIZE + slot * self._slot_size
        self._sequences[slot] += 1
        _SLOT_HEADER.pack_into(self._map, at, self._sequences[slot], number, captured_monotonic_ns)
        pixels = np.frombuffer(self._map, np.uint16, depth.size, at + _SLOT_HEADER_SIZE)
        np.copyto(pixels.reshape(self._shape), depth)
        del pixels
        self._sequences[slot] += 1
        _SEQUENCE.pack_into(self._map, at, self._sequences[slot])
        _NEWEST.pack_into(self._map, _NEWEST_AT, number)
        self._number = number
        return number

    def close(self) -> None:
        self._map.close()


class SharedMemorySource:
    """Reads what a `SharedMemoryWriter` publishes; waits for a file that is not there yet and follows a replaced one.

    `from_monotonic_ns` converts a CLOCK_MONOTONIC stamp to the caller's time in seconds.
    """

    def __init__(self, path: Path, from_monotonic_ns: Callable[[int], float]) -> None:
        self._path = path
        self._from_monotonic_ns = from_monotonic_ns
        self._map: mmap.mmap | None = None
        self._inode = 0
        self._number = 0
        self._received = 0
        self._skipped = 0
        self._intrinsics = Intrinsics(0, 0, 0.0, 0.0, 0.0, 0.0)
        self._depth_unit_m = 0.0
        self._buffers: list[NDArray[np.uint16]] = []

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(received=self._received, skipped=self._skipped)

    @property
    def is_finished(self) -> bool:
        return False

    def latest(self) -> DepthFrame | None:
        if self._map is None and not self._open():
            return None
        frame = self._read()
        if frame is None and self._was_replaced() and self._open():
            frame = self._read()
        return frame

    def close(self) -> None:
        if self._map is not None:
            self._map.close()
            self._map = None

    def _open(self) -> bool:
        try:
            with self._path.open("rb") as file:
                inode = os.fstat(file.fileno()).st_ino
                shared = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (OSError, ValueError):  # not there yet, or still empty
            return False
        if len(shared) < _HEADER_SIZE or shared[: len(_MAGIC)] != _MAGIC:
            shared.close()
            return False
        _, width, height, unit, fx, fy, cx, cy = _HEADER.unpack_from(shared, 0)
        if len(shared) != _HEADER_SIZE + _SLOTS * _slot_size(width, height):
            shared.close()
            return False
        self.close()
        self._map, self._inode, self._number = shared, inode, 0
        self._intrinsics = Intrinsics(width, height, fx, fy, cx, cy)
        self._depth_unit_m = unit
        self._buffers = [np.zeros((height, width), np.uint16) for _ in range(2)]
        return True

    def _was_replaced(self) -> bool:
        try:
            return os.stat(self._path).st_ino != self._inode
        except OSError:
            return False

    def _read(self) -> DepthFrame | None:
        assert self._map is not None
        shape = (self._intrinsics.height_px, self._intrinsics.width_px)
        for _ in range(_ATTEMPTS):
            (newest,) = _NEWEST.unpack_from(self._map, _NEWEST_AT)
            if newest == self._number:
                return None
            at = _HEADER_SIZE + newest % _SLOTS * _slot_size(shape[1], shape[0])
            sequence, number, captured_ns = _SLOT_HEADER.unpack_from(self._map, at)
            if sequence % 2 or number != newest:
                continue
            buffer = self._buffers[self._received % 2]
            pixels = np.frombuffer(self._map, np.uint16, buffer.size, at + _SLOT_HEADER_SIZE)
            np.copyto(buffer, pixels.reshape(shape))
            del pixels
            (after,) = _SEQUENCE.unpack_from(self._map, at)
            if after == sequence:
                self._skipped += max(0, newest - self._number - 1) if self._number else 0
                self._number = newest
                self._received += 1
                t_s = self._from_monotonic_ns(captured_ns)
                return DepthFrame(t_s, newest, buffer, self._depth_unit_m, self._intrinsics)
        return None
