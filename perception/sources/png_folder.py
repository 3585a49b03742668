"""Recorded depth: one 16-bit PNG file or a folder of them, in the order of their names (numbers count as numbers)."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from perception.errors import PerceptionInputError
from perception.sources.api import SourceHealth
from perception.types import DepthFrame, Intrinsics

TIMES_NAME = "timestamps.txt"
"""File beside the images: the time in s that each was taken at, one a line."""


class PngFolderSource:
    """Returns every frame once, one a call; None after the last.

    Times count from the first frame: as `timestamps.txt` has them, without it frame k was taken at k * period_s.
    """

    def __init__(self, path: Path, intrinsics: Intrinsics, *, depth_unit_m: float = 0.001, period_s: float = 1 / 30) -> None:
        self._files = list_frames(path)
        self._intrinsics = intrinsics
        self._depth_unit_m = depth_unit_m
        self._times_s = read_times(path / TIMES_NAME, len(self._files))
        self._period_s = period_s
        self._received = 0

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(received=self._received)

    @property
    def is_finished(self) -> bool:
        return self._received >= len(self._files)

    def latest(self) -> DepthFrame | None:
        if self._received >= len(self._files):
            return None
        number = self._received
        depth = read_depth_png(self._files[number])
        self._received += 1
        t_s = self._times_s[number] if self._times_s else number * self._period_s
        return DepthFrame(t_s, number, depth, self._depth_unit_m, self._intrinsics)

    def close(self) -> None:
        self._files = []


def list_frames(path: Path) -> list[Path]:
    """The PNG files at `path`; PerceptionInputError if there is none."""
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise PerceptionInputError(f"{path}: no such file or folder; name a 16-bit PNG depth image or a folder of them")
    files = sorted((file for file in path.iterdir() if file.suffix.lower() == ".png"), key=_numeric_order)
    if not files:
        raise PerceptionInputError(f"{path}: the folder has no .png file; 16-bit PNG depth images are wanted")
    return files


def read_depth_png(path: Path) -> NDArray[np.uint16]:
    """(height, width) uint16; PerceptionInputError if the file is not a 16-bit single-channel image."""
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise PerceptionInputError(f"{path}: cannot be read: {error.strerror}") from None
    image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
    if image is None:
        raise PerceptionInputError(f"{path}: not a readable image; a 16-bit PNG depth image is wanted")
    if image.dtype != np.uint16 or image.ndim != 2:
        channels = 1 if image.ndim == 2 else image.shape[2]
        raise PerceptionInputError(
            f"{path}: {8 * image.dtype.itemsize}-bit image with {channels} channel(s); 16-bit with one channel is wanted"
        )
    return np.ascontiguousarray(image, np.uint16)


def read_times(path: Path, count: int) -> list[float]:
    """Times in s since the first one, empty without the file; PerceptionInputError unless they are `count` rising numbers."""
    if not path.is_file():
        return []
    try:
        times_s = [float(line) for line in path.read_text().split()]
    except (OSError, ValueError) as error:
        raise PerceptionInputError(f"{path}: {error}; one time in seconds a line is wanted") from None
    if len(times_s) != count:
        raise PerceptionInputError(f"{path}: {len(times_s)} times for {count} images; one a line for each image is wanted")
    for line, (earlier, later) in enumerate(pairwise(times_s), start=2):
        if not earlier < later:
            raise PerceptionInputError(f"{path}: line {line}: {later} is not after {earlier}; rising times are wanted")
    return [time_s - times_s[0] for time_s in times_s]


def _numeric_order(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]
