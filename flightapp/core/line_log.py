"""Log lines on standard error that can never make the caller wait.

A terminal that stops taking text (a full SSH window, Ctrl-S, a pipe that nobody reads) blocks whoever writes to it. Here that
is a thread of its own behind a bounded queue; lines that do not fit are dropped. The recording has every event anyway.
"""

from __future__ import annotations

import logging
import os
import queue
import sys
import threading

LINES_MAX = 500
FORMAT = "%(asctime)s.%(msecs)03d [%(name)s] %(message)s"


class LineLog(logging.Handler):
    """Install with `LineLog.install()`, end with `close()`, which waits at most a second for the last lines."""

    def __init__(self) -> None:
        super().__init__()
        self._lines: queue.Queue[bytes | None] = queue.Queue(LINES_MAX)
        self._thread = threading.Thread(target=self._write, name="log", daemon=True)
        self._thread.start()

    @classmethod
    def install(cls) -> LineLog:
        """Send everything from INFO up through a new LineLog."""
        handler = cls()
        handler.setFormatter(logging.Formatter(FORMAT, datefmt="%H:%M:%S"))
        logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
        return handler

    def emit(self, record: logging.LogRecord) -> None:
        self._put(f"{self.format(record)}\n".encode())

    def close(self) -> None:
        self._put(None)
        self._thread.join(timeout=1.0)
        super().close()

    def _put(self, line: bytes | None) -> None:
        try:
            self._lines.put_nowait(line)
        except queue.Full:
            return

    def _write(self) -> None:
        descriptor = sys.__stderr__.fileno() if sys.__stderr__ is not None else 2
        while (line := self._lines.get()) is not None:
            try:
                os.write(descriptor, line)
            except OSError:
                return
