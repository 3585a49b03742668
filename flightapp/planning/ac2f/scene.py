"""What a motion must stay clear of: obstacle discs, teammates and the evader's keep-out as one array of inflated discs.

Rows are (north_m, east_m, radius_m, v_north_m_s, v_east_m_s, depth_m) at the observation's time, mission frame. A disc in
whose inflation the vehicle already is, by `depth_m` > 0, shrinks to just below the present distance: motions that leave it
stay allowed, motions that go deeper do not, and the planner never freezes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled
from flightapp.planning.plane import Point

GRACE_M = 0.02


@dataclass(frozen=True, slots=True)
class Mover:
    """Another vehicle: position (m), velocity (m/s), and the distance that centres must keep (m)."""

    position: Point
    velocity: Point
    distance_m: float


@compiled("i8(f8[:,::1],f8,f8,f8,f8,f8,f8[:,::1],f8,f8,f8[:,::1])")
def _inflate(
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
    count = 0
    for i in range(discs.shape[0]):
        n = discs[i, 0] + discs[i, 3] * age_s
        e = discs[i, 1] + discs[i, 4] * age_s
        distance = math.hypot(n - own_n, e - own_e)
        if distance - discs[i, 2] > range_m:
            continue
        vehicle = False
        for k in range(trail.shape[0] if discs[i, 2] <= body_radius_max_m else 0):
            reach = discs[i, 2] + body_m
            dn = n - trail[k, 0]
            de = e - trail[k, 1]
            if dn * dn + de * de < reach * reach:
                vehicle = True
                break
        if vehicle:
            continue
        out[count, 0] = n
        out[count, 1] = e
        inflated = discs[i, 2] + inflation_m
        out[count, 2] = max(0.0, min(inflated, distance - 0.02))
        out[count, 3] = discs[i, 3]
        out[count, 4] = discs[i, 4]
        out[count, 5] = max(0.0, inflated - distance)
        count += 1
    return count


def build_scene(
    discs: Array,
    age_s: float,
    own: Point,
    inflation_m: float,
    range_m: float,
    movers: Sequence[Mover],
    trail: Array,
    vehicle_body_m: float,
    vehicle_radius_max_m: float,
) -> Array:
    """Scene (m, 6) around `own` within `range_m`.

    discs: (n, >=5) observed obstacles, `age_s` old. trail: (k, 2) places where other vehicles' centres are or recently
    were: no static obstacle can be within `vehicle_body_m` of them, so such a disc, up to `vehicle_radius_max_m`, is a sighting
    of the vehicle itself.
    """
    out = np.empty((len(discs) + len(movers), 6))
    observed = np.ascontiguousarray(discs, dtype=np.float64)
    count = _inflate(observed, own[0], own[1], age_s, inflation_m, range_m, trail, vehicle_body_m, vehicle_radius_max_m, out)
    for mover in movers:
        distance = math.dist(mover.position, own)
        if distance - mover.distance_m <= range_m:
            out[count] = (
                *mover.position,
                max(0.0, min(mover.distance_m, distance - GRACE_M)),
                *mover.velocity,
                max(0.0, mover.distance_m - distance),
            )
            count += 1
    return out[:count]


@compiled("f8(f8[:,::1],f8,f8,f8)")
def scene_clearance_m(scene: Array, north: float, east: float, saturation_m: float) -> float:
    """Distance of (north, east) to the nearest inflated edge of `scene` (m, 6), at most `saturation_m`."""
    nearest = saturation_m
    for i in range(scene.shape[0]):
        nearest = min(nearest, math.hypot(scene[i, 0] - north, scene[i, 1] - east) - scene[i, 2])
    return nearest


def depth_m(scene: Array) -> float:
    """How deep the vehicle is inside the inflation of the worst disc of `scene`; 0 outside all."""
    return float(scene[:, 5].max()) if len(scene) else 0.0
