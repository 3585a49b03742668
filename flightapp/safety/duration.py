"""For how long something has been so, without a break."""

from __future__ import annotations

import math

PERIOD_MAX_S = 0.2


class Duration:
    """Adds up control periods. One longer than 0.2 s counts as 0.2 s: a gap in the loop confirms nothing by itself."""

    def __init__(self) -> None:
        self._lasted_s = 0.0

    def of(self, is_so: bool, dt_s: float) -> float:
        """Seconds for which `is_so` was true at each call since it last was false, this one included."""
        period = min(max(dt_s, 0.0), PERIOD_MAX_S) if math.isfinite(dt_s) else 0.0
        self._lasted_s = self._lasted_s + period if is_so else 0.0
        return self._lasted_s
