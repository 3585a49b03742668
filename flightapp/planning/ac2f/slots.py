"""Who holds which bearing around the evader: the same answer for every pursuer from the same positions."""

from __future__ import annotations

import math

import numba

from flightapp.core.angles import TWO_PI
from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.records import PARAMETERS_TYPE, Record

SHIFTS = 13  # bearings that a slot may be moved to, its own included


@compiled("f8(f8,f8,f8[:,::1])")
def slot_bearing_rad(evader_n: float, evader_e: float, pursuers: Array) -> float:
    """Bearing (rad, from the evader) of the slot of the first of `pursuers` (k, 2), all slots equally spaced.

    The pursuers keep their order around the evader, so that no two ways cross, and the slots turn so that the total rotation is
    least: the mean of the bearings, each less its rank, gives the turn, from whichever pursuer the ranks are counted. One
    pursuer keeps its own bearing. O(k).
    """
    count = pursuers.shape[0]
    own_n, own_e = pursuers[0]
    own = math.atan2(own_e - evader_e + 0.0, own_n - evader_n)  # no -0.0, which would turn pi to -pi
    total = own
    rank = 0
    for i in range(1, count):
        n, e = pursuers[i]
        other = math.atan2(e - evader_e + 0.0, n - evader_n)
        total += other
        if other < own or (other == own and (n < own_n or (n == own_n and e < own_e))):
            rank += 1
    return wrapped_rad(total / count + (rank - (count - 1) / 2) * (TWO_PI / count))


@compiled(numba.float64(PARAMETERS_TYPE, numba.int64))
def slack_rad(parameters: Record, count: int) -> float:
    """How far one of `count` pursuers may leave its slot alone without opening the encirclement, less what is to spare."""
    if count == 1:
        return math.pi
    free = math.pi - TWO_PI / count
    if count == 2:
        free = math.pi - math.radians(parameters[0].capture_angular_gap_min_deg)
    return max(0.0, free / 2 - math.radians(parameters[0].slot_spare_deg))


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8)")
def free_slot_bearing_rad(
    discs: Array, evader_n: float, evader_e: float, radius_m: float, bearing_rad: float, slack: float, clear_m: float
) -> float:
    """The nearest bearing within `slack` (rad) of `bearing_rad` whose slot is `clear_m` from `discs` (m, 3 or more); else the one
    with the most room.

    Bearings are tried from the near to the far; a disc costs a square root only where it is nearer than those before.
    """
    best = bearing_rad
    best_gap = -1e9
    for step in range(SHIFTS):
        side = 1.0 if step % 2 else -1.0
        shift = side * ((step + 1) // 2) / (SHIFTS // 2) * slack
        n = evader_n + radius_m * math.cos(bearing_rad + shift)
        e = evader_e + radius_m * math.sin(bearing_rad + shift)
        gap = clear_m
        for i in range(discs.shape[0]):
            dn = discs[i, 0] - n
            de = discs[i, 1] - e
            reach = gap + discs[i, 2]
            square = dn * dn + de * de
            if reach > 0.0 and square < reach * reach:
                gap = math.sqrt(square) - discs[i, 2]
                if gap <= best_gap + 1e-9:
                    break
        if gap > best_gap + 1e-9:
            best_gap = gap
            best = bearing_rad + shift
        if best_gap >= clear_m:
            break
    return wrapped_rad(best)
