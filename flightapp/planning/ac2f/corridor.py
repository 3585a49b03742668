"""Whether a straight way past discs is free, what bars it, and how far the discs reach that bar it together.

Disc rows begin with (north_m, east_m, radius_m), not inflated; any more columns are not looked at.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.records import NUMBER, ROWS, TRUTH, WHOLE

GRACE_M = 0.02  # a disc around the vehicle shrinks to this much less than the distance, as in the scene


@compiled(NUMBER(ROWS, WHOLE, NUMBER, NUMBER, NUMBER))
def kept_m(rows: Array, i: int, own_n: float, own_e: float, distance_m: float) -> float:
    """The distance to keep from the centre of disc `i`: radius and `distance_m`, or a little less than there is now."""
    now = math.hypot(rows[i, 0] - own_n, rows[i, 1] - own_e)
    kept: float = max(0.0, min(rows[i, 2] + distance_m, now - GRACE_M))
    return kept


@compiled(WHOLE(ROWS, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def blocking_disc(
    rows: Array, count: int, own_n: float, own_e: float, from_n: float, from_e: float, to_n: float, to_e: float, distance_m: float
) -> int:
    """The disc of `rows` that is met first within `distance_m` of its surface on the way from -> to; -1 where there is none.

    Discs around the own position only block what leads deeper into them.
    """
    way_n = to_n - from_n
    way_e = to_e - from_e
    length2 = way_n * way_n + way_e * way_e
    first = -1
    first_along = np.inf
    for i in range(count):
        dn = rows[i, 0] - from_n
        de = rows[i, 1] - from_e
        along = dn * way_n + de * way_e
        part = min(1.0, max(0.0, along / length2)) if length2 > 0.0 else 0.0
        gap_n = dn - part * way_n
        gap_e = de - part * way_e
        reach = rows[i, 2] + distance_m
        if gap_n * gap_n + gap_e * gap_e >= reach * reach or along >= first_along:
            continue
        reach = kept_m(rows, i, own_n, own_e, distance_m)
        if gap_n * gap_n + gap_e * gap_e < reach * reach:
            first = i
            first_along = along
    return first


@compiled(TRUTH(ROWS, WHOLE, WHOLE, NUMBER, NUMBER))
def is_in_group(rows: Array, count: int, disc: int, distance_m: float, extent_m: float) -> bool:
    """Whether discs without a gap to pass between them, `disc` being one, reach `extent_m` from its centre."""
    marks = np.zeros(count, np.uint8)
    stack = np.empty(count, np.int64)
    marks[disc] = 1
    stack[0] = disc
    depth = 1
    while depth > 0:
        depth -= 1
        i = stack[depth]
        if math.hypot(rows[i, 0] - rows[disc, 0], rows[i, 1] - rows[disc, 1]) + rows[i, 2] > extent_m:
            return True
        for j in range(count):
            if marks[j] == 0:
                dn = rows[j, 0] - rows[i, 0]
                de = rows[j, 1] - rows[i, 1]
                reach = rows[i, 2] + rows[j, 2] + 2.0 * distance_m
                if dn * dn + de * de < reach * reach:
                    marks[j] = 1
                    stack[depth] = j
                    depth += 1
    return False
