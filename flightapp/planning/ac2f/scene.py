"""What a motion must stay clear of: obstacle discs, teammates and the evader's keep-out as one array of inflated discs.

Rows are (north_m, east_m, radius_m, v_north_m_s, v_east_m_s, depth_m) at the observation's time, mission frame. A disc in
whose inflation the vehicle already is, by `depth_m` > 0, shrinks to just below the present distance: motions that leave it
stay allowed, motions that go deeper do not, and the planner never freezes.
"""

from __future__ import annotations

import math

from flightapp.core.clearance import gap_m
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

GRACE_M = 0.02
SCENE_COLUMNS = 6


@compiled("void(f8[::1],f8,f8,f8,f8,f8,f8)")
def fill(row: Array, north: float, east: float, v_north: float, v_east: float, keep_m: float, distance_m: float) -> None:
    """Fill `row` (6,) with a disc of radius `keep_m`, whose centre is `distance_m` away from the vehicle."""
    row[0] = north
    row[1] = east
    row[2] = max(0.0, min(keep_m, distance_m - GRACE_M))
    row[3] = v_north
    row[4] = v_east
    row[5] = max(0.0, keep_m - distance_m)


@compiled("UniTuple(f8,4)(f8[:,::1])")
def _bounds(places: Array) -> tuple[float, float, float, float]:
    """Smallest and largest north, smallest and largest east of `places` (k, >=2)."""
    north_min, north_max, east_min, east_max = math.inf, -math.inf, math.inf, -math.inf
    for k in range(places.shape[0]):
        north_min = min(north_min, places[k, 0])
        north_max = max(north_max, places[k, 0])
        east_min = min(east_min, places[k, 1])
        east_max = max(east_max, places[k, 1])
    return north_min, north_max, east_min, east_max


@compiled("b1(f8[:,::1],f8,f8,f8)")
def is_near_any(places: Array, north: float, east: float, reach_m: float) -> bool:
    """Whether (north, east) is within `reach_m` of one of `places` (k, >=2)."""
    for k in range(places.shape[0]):
        dn = north - places[k, 0]
        de = east - places[k, 1]
        if dn * dn + de * de < reach_m * reach_m:
            return True
    return False


@compiled("i8(f8[:,::1],f8,f8,f8,f8,f8,f8[:,::1],f8,f8,f8[:,::1])")
def inflate(
    discs: Array,
    own_n: float,
    own_e: float,
    age_s: float,
    inflation_m: float,
    range_m: float,
    trail: Array,
    body_m: float,
    body_radius_max_m: float,
    out: Array,
) -> int:
    """Fill the first rows of `out` (>= n, 6) with the obstacles among `discs` within `range_m`, and return how many there are.

    discs: (n, >=5) observed obstacles, `age_s` old. trail: (k, >=2) places where other vehicles' centres are or recently
    were: no static obstacle can be within `body_m` of them, so such a disc, up to `body_radius_max_m`, is a sighting of the
    vehicle itself.
    """
    count = 0
    north_min, north_max, east_min, east_max = _bounds(trail)
    for i in range(discs.shape[0]):
        radius = discs[i, 2]
        north = discs[i, 0] + discs[i, 3] * age_s
        east = discs[i, 1] + discs[i, 4] * age_s
        distance = math.hypot(north - own_n, east - own_e)
        if distance - radius > range_m:
            continue
        reach = radius + body_m
        between = north_min - reach <= north <= north_max + reach and east_min - reach <= east <= east_max + reach
        if between and radius <= body_radius_max_m and is_near_any(trail, north, east, reach):
            continue
        fill(out[count], north, east, discs[i, 3], discs[i, 4], radius + inflation_m, distance)
        count += 1
    return count


@compiled("i8(f8[:,::1],i8,f8[::1],f8,f8,f8,f8)")
def add_vehicle(scene: Array, count: int, vehicle: Array, own_n: float, own_e: float, keep_m: float, range_m: float) -> int:
    """Put `vehicle` (4: north, east, velocity) behind the first `count` rows, if within `range_m`; returns the new count."""
    distance = math.hypot(vehicle[0] - own_n, vehicle[1] - own_e)
    if distance - keep_m > range_m:
        return count
    fill(scene[count], vehicle[0], vehicle[1], vehicle[2], vehicle[3], keep_m, distance)
    return count + 1


@compiled("f8(f8[:,::1],f8,f8,f8)")
def scene_clearance_m(scene: Array, north: float, east: float, saturation_m: float) -> float:
    """Distance of (north, east) to the nearest inflated edge of `scene` (m, 6), at most `saturation_m`."""
    nearest = saturation_m
    for i in range(scene.shape[0]):
        nearest = min(nearest, gap_m(scene[i, 0] - north, scene[i, 1] - east, scene[i, 2]))
    return nearest


@compiled("f8(f8[:,::1])")
def deepest_m(scene: Array) -> float:
    """How deep the vehicle is inside the inflation of the worst disc of `scene`; 0 outside all."""
    deepest = 0.0
    for i in range(scene.shape[0]):
        deepest = max(deepest, scene[i, 5])
    return deepest
