"""What stands where something was to be left out: the place of a teammate or the target, as the camera sees it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENTS
from perception.extraction.surfaces import SurfacePoints
from perception.geometry import CameraPose

_BINS_MIN = 2
_BESIDE_M = 0.6
"""What goes on beside the circle at about the same distance is part of something larger."""


def left_out(points: SurfacePoints, camera: CameraPose, exclude: NDArray[np.float64], noise_1_m: float) -> NDArray[np.float64]:
    """(k, 2) north_m, east_m of the middle of the visible surface in each circle of `exclude` (k, 3: north, east, radius).

    nan where nothing is seen, where it is hidden in part, is cut off by the picture, or goes on outside the circle: then it is
    not the one whole thing that was expected there.
    """
    places = np.full((len(exclude), 2), np.nan)
    bins = np.flatnonzero(points.is_excluded)
    if not len(bins):
        return places
    forward = points.nearest_m[bins]
    right = forward * TANGENTS[bins]
    cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
    north = camera.position_ned_m[0] + forward * cos - right * sin
    east = camera.position_ned_m[1] + forward * sin + right * cos
    for k, (at_north, at_east, radius) in enumerate(exclude.tolist()):
        distance = math.hypot(at_north - camera.position_ned_m[0], at_east - camera.position_ned_m[1])
        reach = radius + 2.0 * noise_1_m * distance**2
        inside = np.hypot(north - at_north, east - at_east) <= reach
        if np.count_nonzero(inside) >= _BINS_MIN and _is_whole(bins[inside], points.nearest_m, reach):
            places[k] = north[inside].mean(), east[inside].mean()
    return places


def _is_whole(bins: NDArray[np.intp], nearest_m: NDArray[np.float64], reach_m: float) -> bool:
    """Whether the thing in `bins` ends on both sides within the picture, with nothing before it."""
    first, last = int(bins[0]), int(bins[-1])
    if first == 0 or last == TANGENT_BINS - 1:
        return False
    nearest, furthest = float(nearest_m[bins].min()), float(nearest_m[bins].max())
    between = nearest_m[first : last + 1]
    if (between < nearest - reach_m).any():
        return False
    beside = nearest_m[[first - 1, last + 1]]
    return not (beside < furthest + _BESIDE_M).any()
