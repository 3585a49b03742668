"""Where to look when nothing is admissible: the middle of the widest free gap between the discs around."""

from __future__ import annotations

import math

from flightapp.core.angles import TWO_PI, wrap_pi
from flightapp.core.types import Array
from flightapp.planning.plane import Point


def widest_gap_bearing(scene: Array, own: Point, range_m: float) -> float | None:
    """Bearing (rad) of the middle of the widest free gap among the discs of `scene` within `range_m`; None without discs."""
    blocked: list[tuple[float, float]] = []
    for north, east, radius, _, _, _ in scene.tolist():
        distance = math.hypot(north - own[0], east - own[1])
        if distance - radius < range_m:
            half = math.asin(min(1.0, radius / distance)) if distance > 0.0 else math.pi / 2
            start = (math.atan2(east - own[1], north - own[0]) - half) % TWO_PI
            blocked.append((start, start + 2.0 * half))
    if not blocked:
        return None
    blocked.sort()
    best_width, best_middle = -1.0, 0.0
    reached = max(max(end for _, end in blocked) - TWO_PI, blocked[0][0] - TWO_PI)
    for start, end in blocked:
        if start - reached > best_width:
            best_width, best_middle = start - reached, (start + reached) / 2
        reached = max(reached, end)
    return wrap_pi(best_middle)
