"""Encirclement by the planner's rule, of the true vehicles."""

from __future__ import annotations

import math

import numba
import numpy as np

from flightapp.core.compiled import compiled
from flightapp.planning.capture import encloses
from flightapp.sim.batch.records import VEHICLE_TYPE, Records


@compiled(numba.boolean(VEHICLE_TYPE, numba.float64, numba.float64))
def encircles(vehicles: Records, zone_m: float, gap_min_deg: float) -> bool:
    """Whether all vehicles but the last surround the last within `zone_m`."""
    count = len(vehicles) - 1
    evader = vehicles[count]
    for i in range(count):
        if math.hypot(vehicles[i].n - evader.n, vehicles[i].e - evader.e) > zone_m:
            return False
    bearings = np.empty(count)
    for i in range(count):
        bearings[i] = math.atan2(vehicles[i].e - evader.e, vehicles[i].n - evader.n)
    return encloses(bearings, gap_min_deg)
