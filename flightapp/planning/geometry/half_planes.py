"""The half-planes that keep a vehicle on its own side of discs, other vehicles and convex polygons.

Rows are (normal_n, normal_e, room_m): the unit normal leads away from the owner, who may go `room_m` along it; negative room
means that it is where it must not be. Wang et al., "OA-ECBVC", arXiv 2312.01326, eqs. 9-11, with normals that point away from
the owner and buffers in metres; the quadratic programme of eq. 11 is a projection onto the polygon.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

COINCIDENT_M = 1e-9
PLANE_COLUMNS = 3
ROUND_COLUMNS = 5


@compiled("i8(f8,f8,f8[:,::1],i8,f8[:,::1],i8)")
def add_rounds(own_n: float, own_e: float, rounds: Array, count: int, planes: Array, filled: int) -> int:
    """Add a plane for each of the first `count` rows of `rounds` (north, east, reach_m, share, tie_rad); returns their number.

    `share` of the distance beyond `reach_m` is the owner's: 1 before a disc, half of it before a vehicle that keeps to the same
    rule. `tie_rad`: where the normal leads if both are in the same place.
    """
    for i in range(count):
        dn = rounds[i, 0] - own_n
        de = rounds[i, 1] - own_e
        distance = math.hypot(dn, de)
        if distance < COINCIDENT_M:
            planes[filled, 0] = math.cos(rounds[i, 4])
            planes[filled, 1] = math.sin(rounds[i, 4])
            distance = 0.0
        else:
            planes[filled, 0] = dn / distance
            planes[filled, 1] = de / distance
        planes[filled, 2] = rounds[i, 3] * (distance - rounds[i, 2])
        filled += 1
    return filled


@compiled("i8(f8,f8,f8[:,::1],i8[::1],f8,f8[:,::1],i8)")
def add_polygons(
    own_n: float, own_e: float, corners: Array, starts: NDArray[np.int64], reach_m: float, planes: Array, filled: int
) -> int:
    """Add a plane for each convex polygon; returns how many there are.

    corners (c, 2) anticlockwise in (north, east); polygon k has those from starts[k] to starts[k + 1]; two are a segment.
    Outside, the normal leads to the nearest point; inside and on the border, back from the nearest edge.
    """
    for k in range(starts.shape[0] - 1):
        first = starts[k]
        last = starts[k + 1]
        best = math.inf
        normal_n = 0.0
        normal_e = 0.0
        depth = math.inf
        into_n = 0.0
        into_e = 0.0
        for i in range(first, last):
            j = i + 1 if i + 1 < last else first
            an = corners[i, 0] - own_n
            ae = corners[i, 1] - own_e
            dn = corners[j, 0] - corners[i, 0]
            de = corners[j, 1] - corners[i, 1]
            share = nearest_share(an, ae, dn, de)
            gap_n = an + share * dn
            gap_e = ae + share * de
            gap = math.hypot(gap_n, gap_e)
            if gap < best:
                best = gap
                normal_n = gap_n
                normal_e = gap_e
            length = math.hypot(dn, de)
            inside = (an * de - ae * dn) / length  # how far inside of this edge
            if inside < depth:
                depth = inside
                into_n = -de / length
                into_e = dn / length
        if depth > COINCIDENT_M or best < COINCIDENT_M:
            best = -max(0.0, depth)
            planes[filled, 0] = into_n
            planes[filled, 1] = into_e
        else:
            planes[filled, 0] = normal_n / best
            planes[filled, 1] = normal_e / best
        planes[filled, 2] = best - reach_m
        filled += 1
    return filled
