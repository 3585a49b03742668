"""Convex polygons as walls: contact with their edges, and discs along them for strategies that know nothing but discs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.boundary import NEVER, crossing
from flightapp.sim.batch.contact import first_within

DISC_RADIUS_M = 0.25
DISC_SPACING = 1.2
"""Times the radius, between the centres of two discs along a wall."""
DISC_DEPTH = math.sqrt(1.0 - (0.5 * DISC_SPACING) ** 2)
"""Times the radius, from a wall to the centres: so deep that no part of the wall is left out, as perception leaves none. A disc
then stands out of its wall by 0.05 m, and of the other wall at a corner by 0.1 m."""


def edge_rows(polygons: Sequence[Array]) -> Array:
    """All edges (w, 4: north, east of both ends) of polygons (k, 2)."""
    rows = [np.hstack((polygon, np.roll(polygon, -1, axis=0))) for polygon in polygons]
    return np.ascontiguousarray(np.concatenate(rows)) if rows else np.zeros((0, 4))


def cover_discs(polygons: Sequence[Array]) -> Array:
    """Discs (d, 7 as in ObstacleSet) that cover every edge, no wider than the polygon is thick."""
    rows = [row for polygon in polygons for row in _along(polygon)]
    return np.array(rows, dtype=np.float64).reshape(-1, 7)


def _along(polygon: Array) -> list[list[float]]:
    middle = polygon.mean(axis=0)
    to = np.roll(polygon, -1, axis=0)
    units = (to - polygon) / np.hypot(*(to - polygon).T)[:, np.newaxis]
    inward = np.column_stack((-units[:, 1], units[:, 0]))
    inward *= np.sign(((middle - polygon) * inward).sum(axis=1))[:, np.newaxis]
    thickness = min(float(((polygon - at) @ normal).max()) for at, normal in zip(polygon, inward, strict=True))
    radius = min(DISC_RADIUS_M, 0.5 * thickness)
    rows = []
    for start, end, unit, normal in zip(polygon, to, units, inward, strict=True):
        length = math.dist(start, end)
        first = 0.5 * DISC_SPACING * radius
        count = max(1, math.ceil((length - 2.0 * first) / (DISC_SPACING * radius)) + 1)
        for share in np.linspace(first, length - first, count) if count > 1 else (0.5 * length,):
            north, east = start + share * unit + DISC_DEPTH * radius * normal
            rows.append([float(north), float(east), radius, 0.0, 0.0, -math.inf, math.inf])
    return rows


@compiled("f8(f8,f8,f8,f8,f8,f8)")
def wall_distance_m(n: float, e: float, pn: float, pe: float, qn: float, qe: float) -> float:
    """From (n, e) to the edge p -> q."""
    share = nearest_share(pn - n, pe - e, qn - pn, qe - pe)
    return math.hypot(pn + share * (qn - pn) - n, pe + share * (qe - pe) - e)


@compiled("f8(f8,f8,f8,f8,f8,f8,f8,f8)")
def way_wall_distance_m(an: float, ae: float, bn: float, be: float, pn: float, pe: float, qn: float, qe: float) -> float:
    """Smallest distance between the way a -> b and the edge p -> q."""
    if crossing(an, ae, bn, be, pn, pe, qn, qe) != NEVER:
        return 0.0
    least = min(wall_distance_m(an, ae, pn, pe, qn, qe), wall_distance_m(bn, be, pn, pe, qn, qe))
    return min(least, wall_distance_m(pn, pe, an, ae, bn, be), wall_distance_m(qn, qe, an, ae, bn, be))


@compiled("f8(f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def first_at_wall(
    an: float, ae: float, bn: float, be: float, pn: float, pe: float, qn: float, qe: float, reach_m: float
) -> float:
    """Where on the way a -> b, in [0, 1], the edge p -> q is first at most `reach_m` away; else NEVER."""
    if wall_distance_m(an, ae, pn, pe, qn, qe) <= reach_m:
        return 0.0
    first = min(
        first_within(an - pn, ae - pe, bn - pn, be - pe, reach_m), first_within(an - qn, ae - qe, bn - qn, be - qe, reach_m)
    )
    length = math.hypot(qn - pn, qe - pe)
    along_n, along_e = (qn - pn) / length, (qe - pe) / length
    before = along_n * (ae - pe) - along_e * (an - pn)
    after = along_n * (be - pe) - along_e * (bn - pn)
    if before < 0.0:
        before, after = -before, -after
    if before > reach_m >= after:
        share = (before - reach_m) / (before - after)
        foot = along_n * (an + share * (bn - an) - pn) + along_e * (ae + share * (be - ae) - pe)
        if 0.0 <= foot <= length:
            first = min(first, share)
    return first
