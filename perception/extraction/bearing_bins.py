"""Bearing bins: equal steps of the tangent of the bearing relative to the camera's heading, as image columns are.

A bin is 0.7 degrees wide straight ahead and narrower aside; together they reach 63 degrees to each side.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

TANGENT_MAX = 2.0
SECTORS = 360
TANGENT_BINS = 320
TANGENT_STEP = 2 * TANGENT_MAX / TANGENT_BINS
TANGENTS = (np.arange(TANGENT_BINS) + 0.5) * TANGENT_STEP - TANGENT_MAX
BEARING_MAX_RAD = math.atan(TANGENT_MAX)
"""Nothing is looked for, and nothing counts as seen, further aside than this."""


def bin_of(bearing_rad: float) -> int:
    """Bin of a bearing relative to the camera's heading; the outermost one for bearings outside."""
    tangent = math.tan(min(max(bearing_rad, -BEARING_MAX_RAD), BEARING_MAX_RAD))
    return min(max(int((tangent + TANGENT_MAX) / TANGENT_STEP), 0), TANGENT_BINS - 1)


def bins_of_sectors() -> NDArray[np.int32]:
    """(360, 2) first and last bin of each half-degree sector ahead, from -90 to 90 degrees; (1, 0), no bin, far aside."""
    borders = np.linspace(-math.pi / 2, math.pi / 2, SECTORS + 1)
    return np.array(
        [
            (bin_of(low), bin_of(high)) if low >= -BEARING_MAX_RAD and high <= BEARING_MAX_RAD else (1, 0)
            for low, high in zip(borders[:-1] + 1e-6, borders[1:] - 1e-6, strict=True)
        ],
        np.int32,
    )
