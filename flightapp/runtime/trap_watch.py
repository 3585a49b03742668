"""Whether a strategy is trapped: it says so, or it has long been going nowhere while something bars the way to its target."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from flightapp.core.types import Array

STUCK = "stuck"
"""The mode in which a strategy says that it is trapped."""
WATCHED_S = 8.0
STAYED_M = 6.0
"""Whoever has not left a box of this diagonal within WATCHED_S goes nowhere."""
NEAR_M = 4.0
"""Nearer to the target, staying is what is wanted."""
PLACES_PERIOD_S = 0.2


class TrapWatch:
    """One vehicle's places of the last WATCHED_S; planar, mission frame."""

    def __init__(self) -> None:
        self._places: deque[tuple[float, float, float]] = deque()

    def reset(self) -> None:
        """Something else than the strategy flew."""
        self._places.clear()

    def trapped(self, t_s: float, place_m: Array, target_m: Array, mode: str, is_barred: Callable[[], bool]) -> str:
        """Why the vehicle counts as trapped; empty while it does not. is_barred: asked only where it decides."""
        places = self._places
        if not places or t_s - places[-1][0] >= PLACES_PERIOD_S:
            places.append((t_s, float(place_m[0]), float(place_m[1])))
        while len(places) > 1 and places[1][0] <= t_s - WATCHED_S:
            places.popleft()
        if math.dist(place_m[:2], target_m[:2]) <= NEAR_M:
            return ""
        if mode == STUCK:
            return "the strategy says that it is stuck"
        if t_s - places[0][0] < WATCHED_S:
            return ""
        stayed_m = math.hypot(*(max(one[axis] for one in places) - min(one[axis] for one in places) for axis in (1, 2)))
        if stayed_m >= STAYED_M or not is_barred():
            return ""
        return f"within {stayed_m:.0f} m for {WATCHED_S:g} s, and the straight way to the evader is barred"
