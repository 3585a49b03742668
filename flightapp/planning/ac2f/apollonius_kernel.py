"""The compiled part of the interception game: regions, candidate points and goals over plain arrays.

A region is a row (kind, centre north, centre east, radius, normal north, normal east): inside of a disc, a half-plane whose
edge passes through the centre and whose normal points to the evader, or outside of a disc.

The game is played in the intersection of the regions. The source's literal reading, their union, is kept for comparison.
n pursuers before s sides: O(n (n + s)) candidate points, each O(s) and, where it is better than the best so far, O(n). From
more than `PRUNE_ABOVE` pursuers, O(n^2) comparisons first drop the regions that contain another one; m of them count then.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array

DISC = 0.0
HALF_PLANE = 1.0
OUTSIDE = 2.0
REGION_COLUMNS = 6

EQUAL_SPEED = 1e-6  # |lambda - 1| below this is the half-plane
TOLERANCE_M = 1e-6
ACTIVE_M = 1e-3
FAR_M = 1e300
PRUNE_ABOVE = 3

Place = tuple[float, float, float]
"""Distance by which it was chosen, north, east."""
Meeting = tuple[int, float, float, float, float]
"""How many points two edges have in common, and north, east of both."""


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


@compiled("b1(f8[:,::1],b1,f8,f8)")
def _allowed(regions: Array, union: bool, n: float, e: float) -> bool:
    """Whether (n, e) lies in all regions, or in any of them for the union."""
    for i in range(regions.shape[0]):
        depth = depth_m(regions[i], n, e)
        if (depth >= -TOLERANCE_M * (1.0 + 1e-6 * regions[i, 3])) == union:
            return union
    return not union


@compiled("b1(f8[:,::1],f8,f8)")
def _outside_all(regions: Array, n: float, e: float) -> bool:
    """Whether (n, e) lies deep in no region: what a point of the union's edge does."""
    for i in range(regions.shape[0]):
        depth = depth_m(regions[i], n, e)
        if depth > TOLERANCE_M * (1.0 + 1e-6 * regions[i, 3]):
            return False
    return True


@compiled("f8[:,::1](f8[:,::1])")
def _tightest(regions: Array) -> Array:
    """The rows of `regions` (n, 6) that contain no other disc among them: their intersection is the same."""
    kept = np.empty_like(regions)
    count = 0
    for i in range(regions.shape[0]):
        is_needed = True
        for j in range(regions.shape[0]):
            if i != j and regions[j, 0] == DISC and depth_m(regions[i], regions[j, 1], regions[j, 2]) >= regions[j, 3]:
                is_same = regions[i, 0] == DISC and depth_m(regions[j], regions[i, 1], regions[i, 2]) >= regions[i, 3]
                if not is_same or j < i:
                    is_needed = False
                    break
        if is_needed:
            for c in range(regions.shape[1]):  # a row at once would take seconds to compile, for its check of the shapes
                kept[count, c] = regions[i, c]
            count += 1
    return kept[:count]


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


@compiled("Tuple((i8,f8,f8,f8,f8))(f8[::1],f8,f8,f8,f8)")
def _edge_and_line(region: Array, an: float, ae: float, along_n: float, along_e: float) -> Meeting:
    """The points of the edge of `region` on the line through (an, ae)."""
    if region[0] == HALF_PLANE:
        slope = along_n * region[4] + along_e * region[5]
        if abs(slope) <= 1e-12:
            return 0, 0.0, 0.0, 0.0, 0.0
        t = -depth_m(region, an, ae) / slope
        return 1, an + t * along_n, ae + t * along_e, 0.0, 0.0
    middle = (region[1] - an) * along_n + (region[2] - ae) * along_e
    foot_n = an + middle * along_n
    foot_e = ae + middle * along_e
    height = math.hypot(foot_n - region[1], foot_e - region[2])
    if height > region[3]:
        return 0, 0.0, 0.0, 0.0, 0.0
    half = math.sqrt((region[3] - height) * (region[3] + height))
    return 2, foot_n + half * along_n, foot_e + half * along_e, foot_n - half * along_n, foot_e - half * along_e


@compiled("Tuple((i8,f8,f8,f8,f8))(f8,f8,f8,f8,f8,f8)")
def _circles_meet(an: float, ae: float, radius_a: float, bn: float, be: float, radius_b: float) -> Meeting:
    """The points common to two circles."""
    distance = math.hypot(bn - an, be - ae)
    if distance == 0.0 or distance > radius_a + radius_b + TOLERANCE_M or distance < abs(radius_a - radius_b) - TOLERANCE_M:
        return 0, 0.0, 0.0, 0.0, 0.0
    along = (distance + (radius_a - radius_b) * (radius_a + radius_b) / distance) / 2
    half = math.sqrt(max(0.0, (radius_a - along) * (radius_a + along)))
    dn = (bn - an) / distance
    de = (be - ae) / distance
    foot_n = an + along * dn
    foot_e = ae + along * de
    return 2, foot_n - half * de, foot_e + half * dn, foot_n + half * de, foot_e - half * dn


@compiled("Tuple((i8,f8,f8,f8,f8))(f8[::1],f8[::1])")
def _edges_meet(first: Array, second: Array) -> Meeting:
    """The points common to the edges of two regions."""
    if first[0] == HALF_PLANE:
        return _edge_and_line(second, first[1], first[2], -first[5], first[4])
    if second[0] == HALF_PLANE:
        return _edge_and_line(first, second[1], second[2], -second[5], second[4])
    return _circles_meet(first[1], first[2], first[3], second[1], second[2], second[3])


@compiled("Tuple((i8,f8,f8,f8,f8))(f8[::1],f8,f8,f8)")
def _edge_and_ring(region: Array, n: float, e: float, radius_m: float) -> Meeting:
    """The points of the edge of `region` at `radius_m` from (n, e)."""
    if region[0] != HALF_PLANE:
        return _circles_meet(n, e, radius_m, region[1], region[2], region[3])
    depth = depth_m(region, n, e)
    if abs(depth) > radius_m:
        return 0, 0.0, 0.0, 0.0, 0.0
    half = math.sqrt((radius_m - depth) * (radius_m + depth))
    foot_n = n - depth * region[4]
    foot_e = e - depth * region[5]
    return 2, foot_n - half * region[5], foot_e + half * region[4], foot_n + half * region[5], foot_e - half * region[4]


@compiled("UniTuple(f8,3)(f8[:,::1],b1,f8,f8,f8,f8,UniTuple(f8,3))")
def _nearer_to_evader(regions: Array, union: bool, n: float, e: float, evader_n: float, evader_e: float, best: Place) -> Place:
    """(n, e) where it is allowed and nearer to the evader than `best`; else `best`."""
    distance = math.hypot(n - evader_n, e - evader_e)
    if distance < best[0] and _allowed(regions, union, n, e):
        return distance, n, e
    return best


@compiled("UniTuple(f8,3)(f8[:,::1],b1,f8[:,::1],f8,f8,UniTuple(f8,3))")
def _nearer_to_boundary(regions: Array, union: bool, sides: Array, n: float, e: float, best: Place) -> Place:
    """(n, e) where it is allowed and nearer to the boundary than `best`; else `best`."""
    distance = _distance_to_all(sides, n, e)
    if distance < best[0] and _allowed(regions, union, n, e):
        return distance, n, e
    return best


@compiled("UniTuple(f8,3)(f8[:,::1],b1,f8[:,::1],f8,f8)")
def _reached(regions: Array, union: bool, sides: Array, evader_n: float, evader_e: float) -> Place:
    """The place on the boundary that the evader reaches first; its distance is `FAR_M` where there is none.

    Candidates: nearest points, corners, and edges of the regions on the boundary.
    """
    best = (FAR_M, evader_n, evader_e)
    for s in range(sides.shape[0]):
        an, ae, bn, be = sides[s]
        fraction = _along(sides[s], evader_n, evader_e)
        foot_n = an + fraction * (bn - an)
        foot_e = ae + fraction * (be - ae)
        best = _nearer_to_evader(regions, union, foot_n, foot_e, evader_n, evader_e, best)
        best = _nearer_to_evader(regions, union, an, ae, evader_n, evader_e, best)
        best = _nearer_to_evader(regions, union, bn, be, evader_n, evader_e, best)
        length = math.hypot(bn - an, be - ae)
        if length == 0.0:
            continue
        for i in range(regions.shape[0]):
            count, n, e, other_n, other_e = _edge_and_line(regions[i], an, ae, (bn - an) / length, (be - ae) / length)
            if count > 0 and _distance_to_side(sides[s], n, e) < TOLERANCE_M:
                best = _nearer_to_evader(regions, union, n, e, evader_n, evader_e, best)
            if count > 1 and _distance_to_side(sides[s], other_n, other_e) < TOLERANCE_M:
                best = _nearer_to_evader(regions, union, other_n, other_e, evader_n, evader_e, best)
    return best


@compiled("UniTuple(f8,3)(f8[:,::1],b1,f8[:,::1],f8,f8)")
def _contested(regions: Array, union: bool, sides: Array, evader_n: float, evader_e: float) -> Place:
    """The place in the regions that is nearest to the boundary: extreme points of each edge, and where two edges meet."""
    best = _nearer_to_boundary(regions, union, sides, evader_n, evader_e, (FAR_M, evader_n, evader_e))
    for i in range(regions.shape[0]):
        region = regions[i]
        if region[0] == HALF_PLANE:  # first: before a parallel side the whole edge is equally near
            best = _nearer_to_boundary(regions, union, sides, region[1], region[2], best)
        for s in range(sides.shape[0]):
            length = math.hypot(sides[s, 2] - sides[s, 0], sides[s, 3] - sides[s, 1])
            if region[0] != HALF_PLANE and length > 0.0:
                out_n = -region[3] * (sides[s, 3] - sides[s, 1]) / length
                out_e = region[3] * (sides[s, 2] - sides[s, 0]) / length
                best = _nearer_to_boundary(regions, union, sides, region[1] + out_n, region[2] + out_e, best)
                best = _nearer_to_boundary(regions, union, sides, region[1] - out_n, region[2] - out_e, best)
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
                best = _nearer_to_boundary(regions, union, sides, n, e, best)
    if union:
        return best
    for i in range(regions.shape[0]):
        for k in range(i + 1, regions.shape[0]):
            count, n, e, other_n, other_e = _edges_meet(regions[i], regions[k])
            if count > 0:
                best = _nearer_to_boundary(regions, union, sides, n, e, best)
            if count > 1:
                best = _nearer_to_boundary(regions, union, sides, other_n, other_e, best)
    return best


@compiled("void(f8[:,::1],f8[::1],f8[:,::1],f8,f8,f8[::1])")
def _mark_active(pursuers: Array, ratios: Array, regions: Array, n: float, e: float, active: Array) -> None:
    """`active` (k,) is 1 for the pursuers whose edge passes through (n, e); where none does, for those that get there first."""
    on_edge = False
    for i in range(regions.shape[0]):
        active[i] = 1.0 if abs(depth_m(regions[i], n, e)) < ACTIVE_M else 0.0
        on_edge = on_edge or active[i] > 0.0
    if on_edge:
        return
    first = FAR_M
    for i in range(regions.shape[0]):
        first = min(first, math.hypot(pursuers[i, 0] - n, pursuers[i, 1] - e) / ratios[i])
    for i in range(regions.shape[0]):
        lead = math.hypot(pursuers[i, 0] - n, pursuers[i, 1] - e) / ratios[i]
        active[i] = 1.0 if lead <= first + 1e-6 else 0.0


@compiled("UniTuple(f8,3)(f8[:,::1],b1,f8,f8,f8,f8,UniTuple(f8,3))")
def _nearer_on_edge(regions: Array, union: bool, n: float, e: float, pursuer_n: float, pursuer_e: float, best: Place) -> Place:
    """(n, e), which lies on one edge, where it is on the edge of all together and nearer to the pursuer than `best`."""
    if union and not _outside_all(regions, n, e):
        return best
    return _nearer_to_evader(regions, union, n, e, pursuer_n, pursuer_e, best)


@compiled("UniTuple(f8,3)(f8[:,::1],b1,f8,f8,f8,f8,f8)")
def _gap_goal(regions: Array, union: bool, n: float, e: float, pursuer_n: float, pursuer_e: float, spacing_m: float) -> Place:
    """On the regions' edge, `spacing_m` beside the game point (n, e), nearest to the pursuer; else the game point."""
    best = (FAR_M, n, e)
    for i in range(regions.shape[0]):
        count, beside_n, beside_e, other_n, other_e = _edge_and_ring(regions[i], n, e, spacing_m)
        if count > 0:
            best = _nearer_on_edge(regions, union, beside_n, beside_e, pursuer_n, pursuer_e, best)
        if count > 1:
            best = _nearer_on_edge(regions, union, other_n, other_e, pursuer_n, pursuer_e, best)
    return best


@compiled("Tuple((b1,f8,f8,f8))(f8[:,::1],f8,f8,f8[::1],f8[:,::1],b1,b1,f8,f8[:,::1],f8[::1],f8[:,::1])")
def solve_game(
    pursuers: Array,
    evader_n: float,
    evader_e: float,
    ratios: Array,
    sides: Array,
    closed: bool,
    union: bool,
    spacing_m: float,
    regions: Array,
    active: Array,
    goals: Array,
) -> tuple[bool, float, float, float]:
    """Whether the boundary is contested, and the game point's north, east and distance from the boundary, m.

    Fills regions (k, 6), active (k,), goals (k, 2). pursuers: (k, 2) m. ratios: (k,) speed ratios lambda. sides: (s, 4) north,
    east of both ends of each side. `union` plays in the union of the regions.
    """
    for i in range(pursuers.shape[0]):
        dominance(pursuers[i, 0], pursuers[i, 1], evader_n, evader_e, ratios[i], regions[i])
    if closed and _inside(sides, evader_n, evader_e):
        active[:] = 1.0
        goals[:, 0] = evader_n
        goals[:, 1] = evader_e
        return False, evader_n, evader_e, 0.0
    tightest = _tightest(regions) if pursuers.shape[0] > PRUNE_ABOVE and not union else regions
    reached_m, n, e = _reached(tightest, union, sides, evader_n, evader_e)
    contested = reached_m >= FAR_M
    if contested:
        _, n, e = _contested(tightest, union, sides, evader_n, evader_e)
    _mark_active(pursuers, ratios, regions, n, e, active)
    for i in range(pursuers.shape[0]):
        goals[i, 0] = n
        goals[i, 1] = e
        if active[i] == 0.0:
            _, goals[i, 0], goals[i, 1] = _gap_goal(tightest, union, n, e, pursuers[i, 0], pursuers[i, 1], spacing_m)
    return contested, n, e, _distance_to_all(sides, n, e)
