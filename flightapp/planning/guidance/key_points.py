"""The points of a way at which it must turn: a greedy walk by sight, not the shortest (CPPPEA 2.7).

The walk is repeated, because over what one has kept the next may see further.
"""

from __future__ import annotations

from collections.abc import Sequence

from flightapp.core.types import Array
from flightapp.planning.guidance.tree import is_barred
from flightapp.planning.plane import Point


def key_points(way: Sequence[Point], discs: Array) -> list[Point]:
    """The points of `way`, without its start, that are needed to fly it straight from one to the next; the last is one.

    ValueError where `way` itself meets one of `discs` (m, >=3).
    """
    points = _walked(way, discs)
    while len(shorter := _walked([way[0], *points], discs)) < len(points):
        points = shorter
    return points


def _walked(way: Sequence[Point], discs: Array) -> list[Point]:
    kept: list[Point] = []
    anchor, i = 0, 1
    while i < len(way):
        if not is_barred(discs, *way[anchor], *way[i]):
            i += 1
            continue
        if anchor == i - 1:
            raise ValueError(f"the way meets an obstacle between its points {i - 1} and {i}")
        anchor = i - 1
        kept.append(way[anchor])
    if len(way) > 1:
        kept.append(way[-1])
    return kept
