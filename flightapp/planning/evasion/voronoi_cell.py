"""The evader's Voronoi cell among the pursuers, and its centroid.

The cell is what is left of a box after a half-plane per pursuer (nearer to the evader than to it) and per obstacle disc (on the
evader's side of the tangent to the inflated disc). Wang et al., "OA-ECBVC", arXiv 2312.01326, eq. 20, with their cells' normals
pointing away from the owner and lengths in metres.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.geometry.convex import centroid, clipped

COINCIDENT_M = 1e-9


@compiled("UniTuple(f8,3)(f8,f8,f8[:,::1],f8[:,::1],f8,f8,f8,f8,f8,f8)")
def cell_centroid(
    own_n: float,
    own_e: float,
    pursuers: Array,
    discs: Array,
    inflation_m: float,
    range_m: float,
    north_min: float,
    east_min: float,
    north_max: float,
    east_max: float,
) -> tuple[float, float, float]:
    """North, east (m) of the centroid of the evader's cell in the given box, and the cell's area (m2), 0 where it is empty.

    pursuers: (k, >=2). discs: (m, >=3), not inflated; those beyond `range_m` are left out. A disc in whose inflation the evader
    is leaves the side away from it.
    """
    capacity = 4 + pursuers.shape[0] + discs.shape[0]
    corners = np.empty((capacity, 2))
    spare = np.empty((capacity, 2))
    corners[0, 0] = corners[1, 0] = north_min
    corners[2, 0] = corners[3, 0] = north_max
    corners[0, 1] = corners[3, 1] = east_min
    corners[1, 1] = corners[2, 1] = east_max
    count = 4
    for i in range(pursuers.shape[0] + discs.shape[0]):
        is_disc = i >= pursuers.shape[0]
        row = discs[i - pursuers.shape[0]] if is_disc else pursuers[i]
        dn = row[0] - own_n
        de = row[1] - own_e
        distance = math.hypot(dn, de)
        if distance < COINCIDENT_M:
            continue
        room_m = 0.5 * distance
        if is_disc:
            room_m = max(0.0, distance - row[2] - inflation_m)
            if room_m > range_m:
                continue
        count = clipped(corners, count, own_n, own_e, dn / distance, de / distance, room_m, spare)
        corners, spare = spare, corners
    return centroid(corners, count)
