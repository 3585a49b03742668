"""Random discs one after another, each where it leaves room: the rejection loop of every family, compiled."""

from __future__ import annotations

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array

CHUNK = 128


@compiled("i8(f8[:,::1],f8[:,::1],f8,f8[:,::1],f8,f8[:,::1],i8,i8)")
def _place(
    candidates: Array, starts: Array, start_clear_m: float, others: Array, gap_m: float, placed: Array, count: int, most: int
) -> int:
    """Writes the candidates (north, east, radius) that find room behind the first `count` rows of `placed`; the new count."""
    for c in range(len(candidates)):
        if count == most:
            break
        n, e, radius = candidates[c, 0], candidates[c, 1], candidates[c, 2]
        room = True
        for k in range(len(starts)):
            dn, de, reach = starts[k, 0] - n, starts[k, 1] - e, radius + start_clear_m
            room = room and dn * dn + de * de >= reach * reach
        for k in range(len(others)):
            dn, de, reach = others[k, 0] - n, others[k, 1] - e, radius + others[k, 2] + gap_m
            room = room and dn * dn + de * de >= reach * reach
        for k in range(count):
            dn, de, reach = placed[k, 0] - n, placed[k, 1] - e, radius + placed[k, 2] + gap_m
            room = room and dn * dn + de * de >= reach * reach
        if room:
            placed[count, 0], placed[count, 1], placed[count, 2] = n, e, radius
            count += 1
    return count


def scattered(
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    most: int,
    attempts_max: int,
    starts: Array,
    start_clear_m: float,
    gap_m: float,
    random: np.random.Generator,
    others: Array | None = None,
) -> Array:
    """Up to `most` discs (k, 3: north, east, radius) drawn evenly between `low` and `high`.

    Each leaves `start_clear_m` to `starts` (s, 2), `gap_m` to every other disc and to `others` (o, 3), between surfaces.
    """
    placed = np.zeros((most, 3))
    standing = np.zeros((0, 3)) if others is None else np.ascontiguousarray(others)
    count = 0
    for first in range(0, attempts_max, CHUNK):
        candidates = random.uniform(low, high, (min(CHUNK, attempts_max - first), 3))
        count = _place(candidates, starts, start_clear_m, standing, gap_m, placed, count, most)
        if count == most:
            break
    return placed[:count]
