"""Convex polygons as rows of corners (c, 2: north, east) of which the first `count` are in use; any turning direction."""

from __future__ import annotations

import math

from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

AREA_MIN_M2 = 1e-9
"""A smaller polygon counts as empty."""


@compiled("i8(f8[:,::1],i8,f8,f8,f8,f8,f8,f8[:,::1])")
def clipped(
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
def centroid(corners: Array, count: int) -> tuple[float, float, float]:
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


@compiled("UniTuple(f8,2)(f8[:,::1],i8,f8,f8)")
def nearest_in(corners: Array, count: int, n: float, e: float) -> tuple[float, float]:
    """The point of a polygon nearest to (n, e): itself where it is inside; (n, e) too where there is no corner."""
    best = math.inf
    best_n = n
    best_e = e
    left = False
    right = False
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        dn = corners[j, 0] - corners[i, 0]
        de = corners[j, 1] - corners[i, 1]
        an = corners[i, 0] - n
        ae = corners[i, 1] - e
        cross = an * de - ae * dn
        left = left or cross > 0.0
        right = right or cross < 0.0
        share = nearest_share(an, ae, dn, de)
        distance = math.hypot(an + share * dn, ae + share * de)
        if distance < best:
            best = distance
            best_n = corners[i, 0] + share * dn
            best_e = corners[i, 1] + share * de
    if left != right and count > 2:
        return n, e
    return best_n, best_e
