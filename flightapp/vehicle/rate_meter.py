"""How often something arrives."""

from __future__ import annotations

from collections import deque
from itertools import pairwise

WINDOW_S = 2.0


class RateMeter:
    """Arrivals a second over the last `WINDOW_S`. Filled by one thread, read by another."""

    def __init__(self) -> None:
        self._arrivals_s: deque[float] = deque(maxlen=1000)

    def note(self, t_s: float) -> None:
        self._arrivals_s.append(t_s)

    def rate_hz(self, t_s: float) -> float:
        """The rate at `t_s`; 0 before two arrivals."""
        arrivals = [arrived for arrived in tuple(self._arrivals_s) if arrived > t_s - WINDOW_S]
        if len(arrivals) < 2:
            return 0.0
        return (len(arrivals) - 1) / max(t_s - arrivals[0], 1e-3)

    def gap_max_s(self, t_s: float) -> float:
        """The longest wait for an arrival in that time, the one that still lasts included; `WINDOW_S` without any."""
        arrivals = [arrived for arrived in tuple(self._arrivals_s) if arrived > t_s - WINDOW_S]
        if not arrivals:
            return WINDOW_S
        return max(later - earlier for earlier, later in pairwise((*arrivals, max(t_s, arrivals[-1]))))
