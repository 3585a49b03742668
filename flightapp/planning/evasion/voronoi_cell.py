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

COINCIDENT_M = 1e-9
AREA_MIN_M2 = 1e-9


@compiled("i8(f8[:,::1],i8,f8,f8,f8,f8,f8,f8[:,::1])")
def _clipped(
    corners: Array, count: int, from_n: float, from_e: float, normal_n: float, normal_e: float, room_m: float, out: Array
) -> int:
    """Fill `out` with the part of a polygon up to `room_m` from (from_n, from_e) along the unit normal; returns its corners."""
    kept = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        here = (corners[i, 0] - from_n) * normal_n + (corners[i, 1] - from_e) * normal_e - room_m
        there = (corners[j, 0] - from_n) * normal_n + (corners[j, 1] - from_e) * normal_e - room_m
        if here <= 0.0:
            out[kept, 0] = corners[i, 0]
            out[kept, 1] = corners[i, 1]
            kept += 1
        if (here < 0.0 and there > 0.0) or (here > 0.0 and there < 0.0):
            part = here / (here - there)
            out[kept, 0] = corners[i, 0] + part * (corners[j, 0] - corners[i, 0])
            out[kept, 1] = corners[i, 1] + part * (corners[j, 1] - corners[i, 1])
            kept += 1
    return kept


@compiled("UniTuple(f8,3)(f8[:,::1],i8)")
def _centroid(corners: Array, count: int) -> tuple[float, float, float]:
    """North, east (m) and area (m2) of a polygon; summed from its first corner, so that far from the origin nothing cancels."""
    twice_area = 0.0
    north = 0.0
    east = 0.0
    for i in range(1, count - 1):
        an = corners[i, 0] - corners[0, 0]
        ae = corners[i, 1] - corners[0, 1]
        bn = corners[i + 1, 0] - corners[0, 0]
        be = corners[i + 1, 1] - corners[0, 1]
        cross = an * be - bn * ae
        twice_area += cross
        north += cross * (an + bn)
        east += cross * (ae + be)
    area = 0.5 * abs(twice_area)
    if area < AREA_MIN_M2:
        return 0.0, 0.0, 0.0
    return corners[0, 0] + north / (3.0 * twice_area), corners[0, 1] + east / (3.0 * twice_area), area


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
        count = _clipped(corners, count, own_n, own_e, dn / distance, de / distance, room_m, spare)
        corners, spare = spare, corners
    return _centroid(corners, count)
