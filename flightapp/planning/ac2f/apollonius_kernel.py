"""The compiled part of the interception game: regions, candidate points and goals over plain arrays.

A region is a row (kind, centre north, centre east, radius, normal north, normal east): inside of a disc, a half-plane whose
edge passes through the centre and whose normal points to the evader, or outside of a disc.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled

DISC = 0.0
HALF_PLANE = 1.0
OUTSIDE = 2.0
REGION_COLUMNS = 6

EQUAL_SPEED = 1e-6  # |lambda - 1| below this is the half-plane
TOLERANCE_M = 1e-6
ACTIVE_M = 1e-3
FAR_M = 1e300


@compiled("void(f8,f8,f8,f8,f8,f8[::1])")
def dominance(pursuer_n: float, pursuer_e: float, evader_n: float, evader_e: float, ratio: float, region: Array) -> None:
    """Fill `region` (6,): what a pursuer with the speed ratio lambda = `ratio` > 0 leaves to the evader."""
    dn = evader_n - pursuer_n
    de = evader_e - pursuer_e
    length = math.hypot(dn, de)
    region[4] = dn / length if length > 0.0 else 0.0
    region[5] = de / length if length > 0.0 else 0.0
    if abs(ratio - 1.0) < EQUAL_SPEED and length > 0.0:
        region[0] = HALF_PLANE
        region[1] = (pursuer_n + evader_n) / 2
        region[2] = (pursuer_e + evader_e) / 2
        region[3] = 0.0
    elif abs(ratio - 1.0) < EQUAL_SPEED:
        region[0] = DISC
        region[1] = evader_n
        region[2] = evader_e
        region[3] = 0.0
    else:
        scale = 1.0 / (ratio * ratio - 1.0)
        region[0] = DISC if ratio > 1.0 else OUTSIDE
        region[1] = evader_n + dn * scale
        region[2] = evader_e + de * scale
        region[3] = ratio * length * abs(scale)


@compiled("f8(f8[::1],f8,f8)")
def depth_m(region: Array, n: float, e: float) -> float:
    """Distance of (n, e) inside the edge of `region`; negative outside."""
    dn = n - region[1]
    de = e - region[2]
    if region[0] == HALF_PLANE:
        ahead: float = dn * region[4] + de * region[5]
        return ahead
    depth: float = region[3] - math.hypot(dn, de)
    return depth if region[0] == DISC else -depth


@compiled("b1(f8[:,::1],f8,f8)")
def _in_all(regions: Array, n: float, e: float) -> bool:
    for i in range(regions.shape[0]):
        depth = depth_m(regions[i], n, e)
        if not depth >= -TOLERANCE_M * (1.0 + 1e-6 * regions[i, 3]):
            return False
    return True


@compiled("f8(f8[::1],f8,f8)")
def _along(side: Array, n: float, e: float) -> float:
    """Where on `side` (4,), in [0, 1], the point nearest to (n, e) is."""
    dn = side[2] - side[0]
    de = side[3] - side[1]
    length2 = dn * dn + de * de
    if length2 == 0.0:
        return 0.0
    fraction: float = ((n - side[0]) * dn + (e - side[1]) * de) / length2
    return min(1.0, max(0.0, fraction))


@compiled("f8(f8[::1],f8,f8)")
def _distance_to_side(side: Array, n: float, e: float) -> float:
    fraction = _along(side, n, e)
    return math.hypot(side[0] + fraction * (side[2] - side[0]) - n, side[1] + fraction * (side[3] - side[1]) - e)


@compiled("f8(f8[:,::1],f8,f8)")
def _distance_to_all(sides: Array, n: float, e: float) -> float:
    nearest = FAR_M
    for i in range(sides.shape[0]):
        nearest = min(nearest, _distance_to_side(sides[i], n, e))
    return nearest


@compiled("b1(f8[:,::1],f8,f8)")
def _inside(sides: Array, n: float, e: float) -> bool:
    """Whether (n, e) lies inside the closed polygon of `sides`."""
    is_inside = False
    for i in range(sides.shape[0]):
        an, ae, bn, be = sides[i]
        if (ae > e) != (be > e) and n < (bn - an) * (e - ae) / (be - ae) + an:
            is_inside = not is_inside
    return is_inside


@compiled("i8(f8[::1],f8,f8,f8,f8,f8[:,::1])")
def _edge_and_line(region: Array, an: float, ae: float, along_n: float, along_e: float, out: Array) -> int:
    """Fill `out` (2, 2) with the points of the edge of `region` on the line through (an, ae), and return how many there are."""
    if region[0] == HALF_PLANE:
        slope = along_n * region[4] + along_e * region[5]
        if abs(slope) <= 1e-12:
            return 0
        t = -depth_m(region, an, ae) / slope
        out[0, 0] = an + t * along_n
        out[0, 1] = ae + t * along_e
        return 1
    middle = (region[1] - an) * along_n + (region[2] - ae) * along_e
    foot_n = an + middle * along_n
    foot_e = ae + middle * along_e
    height = math.hypot(foot_n - region[1], foot_e - region[2])
    if height > region[3]:
        return 0
    half = math.sqrt((region[3] - height) * (region[3] + height))
    out[0, 0] = foot_n + half * along_n
    out[0, 1] = foot_e + half * along_e
    out[1, 0] = foot_n - half * along_n
    out[1, 1] = foot_e - half * along_e
    return 2


@compiled("i8(f8,f8,f8,f8,f8,f8,f8[:,::1])")
def _circles_meet(an: float, ae: float, radius_a: float, bn: float, be: float, radius_b: float, out: Array) -> int:
    """Fill `out` (2, 2) with the points common to two circles, and return how many there are."""
    distance = math.hypot(bn - an, be - ae)
    if distance == 0.0 or distance > radius_a + radius_b + TOLERANCE_M or distance < abs(radius_a - radius_b) - TOLERANCE_M:
        return 0
    along = (distance + (radius_a - radius_b) * (radius_a + radius_b) / distance) / 2
    half = math.sqrt(max(0.0, (radius_a - along) * (radius_a + along)))
    dn = (bn - an) / distance
    de = (be - ae) / distance
    out[0, 0] = an + along * dn - half * de
    out[0, 1] = ae + along * de + half * dn
    out[1, 0] = an + along * dn + half * de
    out[1, 1] = ae + along * de - half * dn
    return 2


@compiled("i8(f8[::1],f8[::1],f8[:,::1])")
def _edges_meet(first: Array, second: Array, out: Array) -> int:
    """Fill `out` (2, 2) with the points common to the edges of two regions, and return how many there are."""
    if first[0] == HALF_PLANE:
        return _edge_and_line(second, first[1], first[2], -first[5], first[4], out)
    if second[0] == HALF_PLANE:
        return _edge_and_line(first, second[1], second[2], -second[5], second[4], out)
    return _circles_meet(first[1], first[2], first[3], second[1], second[2], second[3], out)


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8[::1])")
def _nearer_to_evader(regions: Array, n: float, e: float, evader_n: float, evader_e: float, best: float, point: Array) -> float:
    """Take (n, e) as `point` (2,) where it is allowed and nearer to the evader than `best`; returns the new best distance."""
    distance = math.hypot(n - evader_n, e - evader_e)
    if distance < best and _in_all(regions, n, e):
        point[0] = n
        point[1] = e
        return distance
    return best


@compiled("f8(f8[:,::1],f8[:,::1],f8,f8,f8,f8[::1])")
def _nearer_to_boundary(regions: Array, sides: Array, n: float, e: float, best: float, point: Array) -> float:
    """Take (n, e) as `point` (2,) where it is allowed and nearer to the boundary than `best`; returns the new best distance."""
    distance = _distance_to_all(sides, n, e)
    if distance < best and _in_all(regions, n, e):
        point[0] = n
        point[1] = e
        return distance
    return best


@compiled("b1(f8[:,::1],f8[:,::1],f8,f8,f8[::1])")
def _reached(regions: Array, sides: Array, evader_n: float, evader_e: float, point: Array) -> bool:
    """Whether the evader reaches the boundary first somewhere; `point` (2,) is the nearest such place.

    Candidates: nearest points, corners, and edges of the regions on the boundary.
    """
    best = FAR_M
    found = np.empty((2, 2))
    for s in range(sides.shape[0]):
        an, ae, bn, be = sides[s]
        fraction = _along(sides[s], evader_n, evader_e)
        foot_n = an + fraction * (bn - an)
        foot_e = ae + fraction * (be - ae)
        best = _nearer_to_evader(regions, foot_n, foot_e, evader_n, evader_e, best, point)
        best = _nearer_to_evader(regions, an, ae, evader_n, evader_e, best, point)
        best = _nearer_to_evader(regions, bn, be, evader_n, evader_e, best, point)
        length = math.hypot(bn - an, be - ae)
        if length == 0.0:
            continue
        for i in range(regions.shape[0]):
            for j in range(_edge_and_line(regions[i], an, ae, (bn - an) / length, (be - ae) / length, found)):
                if _distance_to_side(sides[s], found[j, 0], found[j, 1]) < TOLERANCE_M:
                    best = _nearer_to_evader(regions, found[j, 0], found[j, 1], evader_n, evader_e, best, point)
    return best < FAR_M


@compiled("void(f8[:,::1],f8[:,::1],f8,f8,f8[::1])")
def _contested(regions: Array, sides: Array, evader_n: float, evader_e: float, point: Array) -> None:
    """`point` (2,) of the regions nearest to the boundary: extreme points of each edge, and where two edges meet."""
    point[0] = evader_n
    point[1] = evader_e
    best = _nearer_to_boundary(regions, sides, evader_n, evader_e, FAR_M, point)
    found = np.empty((2, 2))
    for i in range(regions.shape[0]):
        region = regions[i]
        for s in range(sides.shape[0]):
            length = math.hypot(sides[s, 2] - sides[s, 0], sides[s, 3] - sides[s, 1])
            if region[0] != HALF_PLANE and length > 0.0:
                out_n = -region[3] * (sides[s, 3] - sides[s, 1]) / length
                out_e = region[3] * (sides[s, 2] - sides[s, 0]) / length
                best = _nearer_to_boundary(regions, sides, region[1] + out_n, region[2] + out_e, best, point)
                best = _nearer_to_boundary(regions, sides, region[1] - out_n, region[2] - out_e, best, point)
            for corner in range(2):
                n = sides[s, 2 * corner]
                e = sides[s, 2 * corner + 1]
                if region[0] == HALF_PLANE:
                    depth = depth_m(region, n, e)
                    n -= depth * region[4]
                    e -= depth * region[5]
                else:
                    distance = math.hypot(n - region[1], e - region[2])
                    scale = region[3] / distance if distance > 0.0 else 0.0
                    n = region[1] + scale * (n - region[1])
                    e = region[2] + scale * (e - region[2])
                best = _nearer_to_boundary(regions, sides, n, e, best, point)
    for i in range(regions.shape[0]):
        for k in range(i + 1, regions.shape[0]):
            for j in range(_edges_meet(regions[i], regions[k], found)):
                best = _nearer_to_boundary(regions, sides, found[j, 0], found[j, 1], best, point)


@compiled("void(f8[:,::1],f8[::1],f8[:,::1],f8[::1],f8[::1])")
def _mark_active(pursuers: Array, ratios: Array, regions: Array, point: Array, active: Array) -> None:
    """`active` (k,) is 1 for the pursuers whose edge passes through `point`; where none does, for those that get there first."""
    on_edge = False
    for i in range(regions.shape[0]):
        active[i] = 1.0 if abs(depth_m(regions[i], point[0], point[1])) < ACTIVE_M else 0.0
        on_edge = on_edge or active[i] > 0.0
    if on_edge:
        return
    first = FAR_M
    for i in range(regions.shape[0]):
        first = min(first, math.hypot(pursuers[i, 0] - point[0], pursuers[i, 1] - point[1]) / ratios[i])
    for i in range(regions.shape[0]):
        lead = math.hypot(pursuers[i, 0] - point[0], pursuers[i, 1] - point[1]) / ratios[i]
        active[i] = 1.0 if lead <= first + 1e-6 else 0.0


@compiled("void(f8[:,::1],f8[::1],f8,f8,f8,f8[::1])")
def _gap_goal(regions: Array, point: Array, pursuer_n: float, pursuer_e: float, spacing_m: float, goal: Array) -> None:
    """`goal` (2,) on the regions' edge, `spacing_m` beside the game point, nearest to the pursuer; else the game point."""
    goal[0] = point[0]
    goal[1] = point[1]
    ring = np.array((DISC, point[0], point[1], spacing_m, 0.0, 0.0))
    found = np.empty((2, 2))
    best = FAR_M
    for i in range(regions.shape[0]):
        for j in range(_edges_meet(ring, regions[i], found)):
            best = _nearer_to_evader(regions, found[j, 0], found[j, 1], pursuer_n, pursuer_e, best, goal)


@compiled("b1(f8[:,::1],f8,f8,f8[::1],f8[:,::1],b1,f8,f8[:,::1],f8[::1],f8[::1],f8[:,::1])")
def solve_game(
    pursuers: Array,
    evader_n: float,
    evader_e: float,
    ratios: Array,
    sides: Array,
    closed: bool,
    spacing_m: float,
    regions: Array,
    point: Array,
    active: Array,
    goals: Array,
) -> bool:
    """Whether the boundary is contested; fills regions (k, 6), point (3: north, east, distance), active (k,), goals (k, 2).

    pursuers: (k, 2) m. ratios: (k,) speed ratios lambda. sides: (s, 4) north, east of both ends of each side.
    """
    for i in range(pursuers.shape[0]):
        dominance(pursuers[i, 0], pursuers[i, 1], evader_n, evader_e, ratios[i], regions[i])
    if closed and _inside(sides, evader_n, evader_e):
        point[0] = evader_n
        point[1] = evader_e
        point[2] = 0.0
        active[:] = 1.0
        goals[:, 0] = evader_n
        goals[:, 1] = evader_e
        return False
    contested = not _reached(regions, sides, evader_n, evader_e, point)
    if contested:
        _contested(regions, sides, evader_n, evader_e, point)
    point[2] = _distance_to_all(sides, point[0], point[1])
    _mark_active(pursuers, ratios, regions, point, active)
    for i in range(pursuers.shape[0]):
        if active[i] > 0.0:
            goals[i, 0] = point[0]
            goals[i, 1] = point[1]
        else:
            _gap_goal(regions, point, pursuers[i, 0], pursuers[i, 1], spacing_m, goals[i])
    return contested
