"""Encirclement as flightapp.planning.capture states it, compiled."""

from __future__ import annotations

import math

import numba
import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.sim.batch.records import VEHICLE_TYPE, Records


@compiled("f8(f8[::1])")
def widest_gap_rad(bearings: Array) -> float:
    """The widest angle between neighbouring bearings (k,), which it sorts; 2 pi for one."""
    bearings.sort()
    widest: float = 2.0 * math.pi - (bearings[-1] - bearings[0])
    for k in range(1, len(bearings)):
        widest = max(widest, bearings[k] - bearings[k - 1])
    return widest


@compiled(numba.boolean(VEHICLE_TYPE, numba.float64, numba.float64))
def encircles(vehicles: Records, zone_m: float, gap_min_rad: float) -> bool:
    """Whether all vehicles but the last surround the last within `zone_m`."""
    count = len(vehicles) - 1
    evader = vehicles[count]
    for i in range(count):
        if math.hypot(vehicles[i].n - evader.n, vehicles[i].e - evader.e) > zone_m:
            return False
    if count == 1:
        return True
    bearings = np.empty(count)
    for i in range(count):
        bearings[i] = math.atan2(vehicles[i].e - evader.e, vehicles[i].n - evader.n)
    gap = widest_gap_rad(bearings)
    if count == 2:
        return 2.0 * math.pi - gap >= gap_min_rad
    return gap < math.pi
