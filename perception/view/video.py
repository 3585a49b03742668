"""Pictures -> an MP4 file that keeps time: a gap between frames shows as a standing picture, not as a jump.

MPEG-4 Part 2 (`mp4v`), the one codec for MP4 that OpenCV's wheels encode without a further library; VLC, mpv and ffmpeg play it.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from perception.errors import PerceptionInputError
from perception.view.lettering import Picture

_GAP_MAX_S = 5.0
"""A longer gap between two frames is shown this long: a recording that jumps does not become hours of one picture."""


class VideoFile:
    """The file appears under its name when it is closed, complete; without a picture none appears.

    still_s: how long the last picture stands at the end. PerceptionInputError if it cannot be written.
    """

    def __init__(self, path: Path, rate_hz: float, still_s: float = 0.0) -> None:
        if path.is_dir() or not path.parent.is_dir():
            raise PerceptionInputError(f"--video = '{path}': a file in a folder that exists is wanted")
        self._path = path
        self._new = path.with_name(f".{path.name}")
        try:
            self._new.touch()
            self._new.unlink()
        except OSError as error:
            raise PerceptionInputError(f"--video = '{path}': cannot be written: {error.strerror}") from None
        self._rate_hz = rate_hz
        self._still_s = still_s
        self._writer: cv2.VideoWriter | None = None
        self._last: Picture | None = None
        self._last_s = 0.0
        self._due = 0.0
        self._written = 0

    def add(self, t_s: float, picture: Picture) -> None:
        """t_s: when the picture was taken; of pictures that come faster than the video runs, the last of each period stays."""
        if self._last is not None:
            self._due += self._rate_hz * min(max(t_s - self._last_s, 0.0), _GAP_MAX_S)
            self._write_until(round(self._due))
        self._last, self._last_s = picture, t_s

    def close(self) -> None:
        if self._last is not None:
            self._write_until(round(self._due) + max(1, round(self._still_s * self._rate_hz)))
            self._last = None
        if self._writer is None:
            return
        self._writer.release()
        self._writer = None
        written = _frames_in(self._new)
        if written != self._written:
            self._new.unlink(missing_ok=True)
            raise PerceptionInputError(
                f"--video = '{self._path}': only {written} of {self._written} pictures could be written; is the disk full?"
            )
        self._new.replace(self._path)

    def _write_until(self, count: int) -> None:
        """The last picture once or more, until the video has `count` pictures."""
        assert self._last is not None
        if self._written >= count:
            return
        if self._writer is None:
            self._writer = self._open(self._last)
            self._size = self._last.shape
        picture = _fitted(self._last, self._size[0], self._size[1])
        while self._written < count:
            self._writer.write(picture)
            self._written += 1

    def _open(self, picture: Picture) -> cv2.VideoWriter:
        size = (picture.shape[1], picture.shape[0])
        writer = cv2.VideoWriter(str(self._new), cv2.VideoWriter.fourcc(*"mp4v"), self._rate_hz, size)
        if not writer.isOpened():
            raise PerceptionInputError(f"--video = '{self._path}': this build of OpenCV cannot write MPEG-4 video")
        return writer


def _fitted(picture: Picture, height: int, width: int) -> Picture:
    """Cut or filled up to the size that the video began with."""
    if picture.shape[:2] == (height, width):
        return picture
    fitted = np.zeros((height, width, 3), np.uint8)
    rows, columns = min(height, picture.shape[0]), min(width, picture.shape[1])
    fitted[:rows, :columns] = picture[:rows, :columns]
    return fitted


def _frames_in(path: Path) -> int:
    reader = cv2.VideoCapture(str(path))
    try:
        return int(reader.get(cv2.CAP_PROP_FRAME_COUNT)) if reader.isOpened() else 0
    finally:
        reader.release()
