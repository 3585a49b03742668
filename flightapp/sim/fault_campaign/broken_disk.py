"""A disk that is full on demand, under a recorder."""

from __future__ import annotations

import errno
import io
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from flightapp.recording.sink import create_file

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class BreakableDisk:
    """Where one vehicle records."""

    def __init__(self) -> None:
        self.is_full = False

    def open_file(self, path: Path) -> BinaryIO:
        return io.BufferedWriter(_File(create_file(path), self))


class _File(io.RawIOBase):
    """A file on that disk."""

    def __init__(self, file: BinaryIO, disk: BreakableDisk) -> None:
        super().__init__()
        self._file, self._disk = file, disk

    def writable(self) -> bool:
        return True

    def write(self, data: ReadableBuffer) -> int:
        if self._disk.is_full:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self._file.write(data)

    def fileno(self) -> int:
        return self._file.fileno()

    def close(self) -> None:
        if not self.closed:
            self._file.close()
            super().close()
