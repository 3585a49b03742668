"""Encirclement of the true evader by the true pursuers: by the capture rule, and as it is measured."""

from __future__ import annotations

import math

import numba
import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.capture import encloses, forms_polygon, widest_gap_rad
from flightapp.sim.batch.records import VEHICLE_TYPE, WORLD_TYPE, Records

STRAIGHT_RAD = 1e-9
"""A gap is narrower than pi by this, or the pursuers and the evader stand on one line: the hull has no area on one side."""


@compiled(numba.float64[:, ::1](VEHICLE_TYPE))
def _seen_from_evader(vehicles: Records) -> Array:
    """(2, k): bearing and distance of the k pursuers that live, in their order."""
    last = len(vehicles) - 1
    evader = vehicles[last]
    living = 0
    for i in range(last):
        living += 1 - vehicles[i].gone
    seen = np.empty((2, living))
    k = 0
    for i in range(last):
        if vehicles[i].gone == 0:
            dn, de = vehicles[i].n - evader.n, vehicles[i].e - evader.e
            seen[0, k], seen[1, k] = math.atan2(de, dn), math.hypot(dn, de)
            k += 1
    return seen


@compiled(numba.boolean(VEHICLE_TYPE, numba.float64, numba.float64))
def encircles(vehicles: Records, zone_m: float, gap_min_deg: float) -> bool:
    """Whether all vehicles but the last, without those that failed, surround the last within `zone_m`."""
    seen = _seen_from_evader(vehicles)
    for k in range(seen.shape[1]):
        if seen[1, k] > zone_m:
            return False
    return seen.shape[1] > 0 and encloses(seen[0], gap_min_deg)


@compiled(numba.boolean(WORLD_TYPE, VEHICLE_TYPE))
def in_formation(world: Records, vehicles: Records) -> bool:
    """Whether the pursuers that live stand around the evader as a regular polygon, by the world's rule."""
    w = world[0]
    seen = _seen_from_evader(vehicles)
    return bool(forms_polygon(seen[0], seen[1], w.hold_radius, w.hold_tolerance, w.gap_tolerance))


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, numba.float64, numba.float64))
def measure_encirclement(world: Records, vehicles: Records, t_s: float, lasted_s: float) -> None:
    """Whether the evader is inside the hull of the pursuers at `t_s`, counted for the last `lasted_s`."""
    w = world[0]
    seen = _seen_from_evader(vehicles)
    inside = seen.shape[1] >= 3 and widest_gap_rad(seen[0]) < math.pi - STRAIGHT_RAD
    w.encircled = inside
    if inside:
        w.encircled_s += lasted_s
        if math.isnan(w.encircled_first_s):
            w.encircled_first_s = t_s
