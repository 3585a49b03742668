"""Whether a straight way keeps its distance, in continuous time: sphere tracing through the broad phase."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.space.bodies import BODIES, NUMBER
from flightapp.space.broad_phase import CELLS, Cells, near_gap

RESOLUTION_M = 0.02


@compiled(numba.types.boolean(BODIES, CELLS, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def is_way_free(
    bodies: Array,
    cells: Cells,
    north: float,
    east: float,
    down: float,
    along_n: float,
    along_e: float,
    along_d: float,
    gap_m: float,
) -> bool:
    """Whether the straight way from a point by `along` keeps at least `gap_m` from every body at rest.

    The signed distance changes by no more than the way flown. A step of the present surplus and half of `RESOLUTION_M`, which
    every next place has as surplus, therefore leaves nothing out: a way that is called free is free at every point, and one
    is refused that comes nearer than gap_m + RESOLUTION_M / 2. `cells` must reach farther than that.
    """
    length = math.sqrt(along_n * along_n + along_e * along_e + along_d * along_d)
    if not math.isfinite(length + north + east + down):
        return False  # what is not a number would be compared for ever
    flown = 0.0
    while True:
        share = flown / length if length > 0.0 else 0.0
        surplus = near_gap(bodies, cells, north + share * along_n, east + share * along_e, down + share * along_d) - gap_m
        if surplus < 0.5 * RESOLUTION_M:
            return False
        if flown >= length:
            return True
        flown = min(length, flown + surplus + 0.5 * RESOLUTION_M)
