"""Who holds which bearing around the evader: the same answer for every pursuer from the same positions."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightapp.core.angles import TWO_PI, wrap_pi
from flightapp.planning.plane import Point


def slot_bearings(evader: Point, pursuers: Sequence[Point]) -> tuple[float, ...]:
    """Bearing (rad, from the evader) of the slot of each of `pursuers`, equally spaced, with the least total rotation.

    The pursuers keep their order around the evader, so that no two ways cross. One pursuer keeps its own bearing.
    """
    count = len(pursuers)
    bearings = [math.atan2(e - evader[1], n - evader[0]) for n, e in pursuers]
    order = sorted(range(count), key=lambda index: (bearings[index], pursuers[index]))
    start = _after_widest_gap([bearings[index] for index in order])
    order = order[start:] + order[:start]
    first = bearings[order[0]]
    unwound = [first + (bearings[index] - first) % TWO_PI for index in order]
    spacing = TWO_PI / count
    turn = sum(bearing - rank * spacing for rank, bearing in enumerate(unwound)) / count
    slots = [0.0] * count
    for rank, index in enumerate(order):
        slots[index] = wrap_pi(turn + rank * spacing)
    return tuple(slots)


def slack_rad(count: int, angular_gap_min_deg: float) -> float:
    """How far one of `count` pursuers may leave its slot alone without opening the encirclement, with 5 deg to spare."""
    if count == 1:
        return math.pi
    free = math.pi - math.radians(angular_gap_min_deg) if count == 2 else math.pi - TWO_PI / count
    return max(0.0, free / 2 - math.radians(5.0))


def _after_widest_gap(ordered_rad: Sequence[float]) -> int:
    gaps = [(ordered_rad[rank] - ordered_rad[rank - 1]) % TWO_PI for rank in range(len(ordered_rad))]
    return max(range(len(gaps)), key=lambda rank: gaps[rank])
