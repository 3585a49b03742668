"""Between the vehicles of a formation: repulsion, and its gain that grows where neighbours come too near (specification 2.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba

from flightapp.control.flat import FlatGains
from flightapp.control.observer import VECTOR
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.space.bodies import BODIES

ROWS = BODIES


@dataclass(frozen=True, slots=True)
class FormationGains(FlatGains):
    """In the order of the kernels' array; the constants below name the places."""

    spacing_m: float = 5.0
    """Smallest distance of two vehicles."""
    spare_m: float = 1.0
    """Added to it before the gain begins to grow."""
    range_m: float = 8.0
    gain_min_m2_s: float = 1.0
    gain_max_m2_s: float = 10.0
    growth: float = 2.0
    """Of the gain: m^2/s a second for each metre that is missing."""
    decay_s: float = 3.0
    smoothing_s: float = 0.1
    correction_max_m_s: float = 3.0


SPACING, SPARE, RANGE, GAIN_MIN, GAIN_MAX, GROWTH, DECAY, SMOOTHING, CORRECTION_MAX = range(9)


@compiled(numba.float64(VECTOR, numba.float64, numba.float64, numba.float64))
def adapted_gain(gains: Array, gain: float, nearest_m: float, dt_s: float) -> float:
    """The repulsion gain of a vehicle after `dt_s`, its nearest neighbour at `nearest_m`; back at its least within 5 decays.

    The source adapts to the mean distance, which may be fine while two collide, and never comes back.
    """
    missing = max(0.0, gains[SPACING] + gains[SPARE] - nearest_m)
    change = gains[GROWTH] * missing - (gain - gains[GAIN_MIN]) / gains[DECAY]
    adapted: float = min(gains[GAIN_MAX], max(gains[GAIN_MIN], gain + min(dt_s, gains[DECAY]) * change))
    return adapted


@compiled(numba.float64(VECTOR, ROWS, VECTOR, numba.int64, VECTOR))
def repel(gains: Array, positions: Array, pair_gains: Array, i: int, push: Array) -> float:
    """push (3,): velocity of vehicle `i` away from the others; returns the distance of the nearest, m.

    positions (n, 3), pair_gains (n,): every vehicle's own. A pair pushes with the greater of its two, so that what one does the
    other does the other way round. Two in one place part along a fixed direction, the lower number to the north.
    """
    push[0] = push[1] = push[2] = 0.0
    nearest = math.inf
    for j in range(positions.shape[0]):
        if j == i:
            continue
        dn, de, dd = positions[i, 0] - positions[j, 0], positions[i, 1] - positions[j, 1], positions[i, 2] - positions[j, 2]
        distance = math.sqrt(dn * dn + de * de + dd * dd)
        nearest = min(nearest, distance)
        if distance >= gains[RANGE]:
            continue
        if distance < 1e-6:
            dn, de, dd, distance = (1.0 if i < j else -1.0), 0.0, 0.0, 1.0
            size = gains[CORRECTION_MAX]
        else:
            size = max(pair_gains[i], pair_gains[j]) * (1.0 / distance - 1.0 / gains[RANGE])
            size = min(size, gains[CORRECTION_MAX])
        push[0] += size * dn / distance
        push[1] += size * de / distance
        push[2] += size * dd / distance
    return nearest
