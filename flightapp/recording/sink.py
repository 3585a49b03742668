"""The file under the recorder: what the disk does wrong stays here."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

OpenFile = Callable[[Path], BinaryIO]


def create_file(path: Path) -> BinaryIO:
    """A new file at `path` with its folder; FileExistsError rather than overwriting."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path.open("xb")


class Sink:
    """A file object for the MCAP writer. After the first failure it swallows everything and says so in `error`.

    The writing library calls `write`, `seek` and `flush` from native code, where an exception would be lost or fatal.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._position = 0
        self.error: str | None = None

    def write(self, data: bytes | bytearray) -> int:
        if self.error is None:
            try:
                self._file.write(data)
            except (OSError, ValueError) as error:
                self._fail(error)
        self._position += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Answers where the file stands. The writer runs without seeking, so no other request is meaningful."""
        if whence == os.SEEK_SET and offset != self._position:
            raise ValueError("the recording is written strictly forward")
        return self._position

    def flush(self) -> None:
        if self.error is None:
            try:
                self._file.flush()
            except (OSError, ValueError) as error:
                self._fail(error)

    def synchronise(self) -> None:
        """Hand everything to the disk: survives a power cut from here on."""
        self.flush()
        if self.error is None:
            try:
                os.fsync(self._file.fileno())
            except (OSError, ValueError) as error:
                self._fail(error)

    def close(self) -> None:
        self.synchronise()
        try:
            self._file.close()
        except (OSError, ValueError) as error:
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        if self.error is None:
            self.error = (error.strerror if isinstance(error, OSError) else None) or str(error)
