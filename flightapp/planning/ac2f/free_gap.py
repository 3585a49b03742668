"""Where to look when nothing is admissible: the middle of the widest free gap between the discs around."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.angles import TWO_PI
from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("f8(f8[:,::1],f8,f8,f8)")
def free_gap_rad(scene: Array, n: float, e: float, range_m: float) -> float:
    """Bearing (rad) of the middle of the widest free gap among the discs of `scene` (m, 6) within `range_m`; NaN: none."""
    starts = np.empty(scene.shape[0])
    ends = np.empty(scene.shape[0])
    count = 0
    reached = -math.inf
    for i in range(scene.shape[0]):
        dn = scene[i, 0] - n
        de = scene[i, 1] - e
        distance = math.hypot(dn, de)
        if distance - scene[i, 2] >= range_m:
            continue
        half = math.asin(min(1.0, scene[i, 2] / distance)) if distance > 0.0 else 0.5 * math.pi
        start = (math.atan2(de, dn) - half) % TWO_PI
        reached = max(reached, start + 2.0 * half - TWO_PI)
        k = count  # by insertion: there are a few, and the library's sort takes seconds to compile
        while k > 0 and starts[k - 1] > start:
            starts[k] = starts[k - 1]
            ends[k] = ends[k - 1]
            k -= 1
        starts[k] = start
        ends[k] = start + 2.0 * half
        count += 1
    if count == 0:
        return math.nan
    reached = max(reached, starts[0] - TWO_PI)
    widest = -1.0
    middle = 0.0
    for i in range(count):
        if starts[i] - reached > widest:
            widest = starts[i] - reached
            middle = 0.5 * (starts[i] + reached)
        reached = max(reached, ends[i])
    return middle
