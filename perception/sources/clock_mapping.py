"""When was a camera frame taken, in the caller's time?"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

_WINDOW = 300


class CaptureClock:
    """Maps a camera's stamps to the caller's time.

    Stamps in the host's Unix time give the age of the frame directly. Stamps of the camera's own clock are shifted so that the
    quickest of the last frames took no time at all: the transport's fixed delay (a few ms) stays unknown.
    """

    def __init__(self, now_s: Callable[[], float], unix_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self._unix_s = unix_s
        self._offsets_s: deque[float] = deque(maxlen=_WINDOW)

    def capture_s(self, stamp_s: float, is_unix: bool) -> float:
        """Capture time of the frame that has just arrived; never later than now."""
        now_s = self._now_s()
        if is_unix:
            return now_s - max(0.0, self._unix_s() - stamp_s)
        self._offsets_s.append(now_s - stamp_s)
        return stamp_s + min(self._offsets_s)
