"""When was a camera frame taken, in the caller's time?"""

from __future__ import annotations

from collections import deque

WINDOW_S = 10.0
"""How long the quickest frame counts; at 100 ppm of drift the mapping moves by 1 ms in it."""
AGE_MAX_S = 2.0
"""A frame that claims to be older in Unix time says more of the host's clock, which was set meanwhile, than of its age."""
COUNTER_S = 2**32 * 1e-6
"""Span of the cameras' 32-bit microsecond counter: it starts again at zero every 71.6 minutes."""
_JUMP_S = 1.0


class CaptureClock:
    """Maps a camera's stamps to the caller's time.

    Stamps in the host's Unix time give the age of the frame directly. Stamps of the camera's own clock are shifted so that the
    quickest frame of the last ten seconds took no time at all: the transport's fixed delay (a few ms) stays unknown, drift is
    followed. A counter that wraps goes on; one that starts anew (camera restarted) or leaps ahead is learnt anew.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget what was learnt: the camera has been started again."""
        self._candidates: deque[tuple[float, float]] = deque()
        self._last: tuple[float, float] | None = None
        self._wrapped_s = 0.0

    def capture_s(self, stamp_s: float, arrival_s: float, age_s: float | None = None) -> float:
        """Capture time of a frame that arrived at `arrival_s`; never later than that.

        age_s: by the host's Unix time, for stamps in it.
        """
        offset_s = self._shift(stamp_s, arrival_s)
        if age_s is not None and -_JUMP_S <= age_s <= AGE_MAX_S:
            return arrival_s - max(0.0, age_s)
        return min(arrival_s, stamp_s + self._wrapped_s + offset_s)

    def _shift(self, stamp_s: float, arrival_s: float) -> float:
        """Least arrival - stamp within the window. The candidates' offsets rise from the oldest to the newest."""
        if self._last is not None and stamp_s < self._last[0]:
            self._start_over(stamp_s, arrival_s, *self._last)
        offset_s = arrival_s - stamp_s - self._wrapped_s
        if self._candidates and offset_s < self._candidates[0][1] - _JUMP_S:
            self._candidates.clear()
        self._last = stamp_s, arrival_s
        while self._candidates and self._candidates[-1][1] >= offset_s:
            self._candidates.pop()
        self._candidates.append((arrival_s, offset_s))
        while self._candidates[0][0] < arrival_s - WINDOW_S:
            self._candidates.popleft()
        return self._candidates[0][1]

    def _start_over(self, stamp_s: float, arrival_s: float, last_stamp_s: float, last_arrival_s: float) -> None:
        unexplained_s = stamp_s + COUNTER_S - last_stamp_s - (arrival_s - last_arrival_s)
        if abs(unexplained_s) < _JUMP_S:
            self._wrapped_s += COUNTER_S
        else:
            self._candidates.clear()
