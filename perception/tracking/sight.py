"""Which discs a frame showed wholly, and through which it looked."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import BEARING_MAX_RAD, TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.kernel_cache import njit
from perception.sighting import View

_SEEN_THROUGH_FRACTION = 0.5
_F8, _B1 = numba.types.float64, numba.types.boolean
_LOOK = numba.void(_F8[:, ::1], _F8[::1], _F8, _F8, _F8, _F8, _B1[::1], _F8[::1], _F8, _F8, _F8, _B1[::1], _B1[::1])


def look(
    view: View, discs: NDArray[np.float64], sigma_m: NDArray[np.float64], tolerance_m: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Of discs (n, 3), north, east, radius in the mission frame: (n,) wholly in view, (n,) seen through.

    Wholly in view: both its edges and its centre lie in sectors that were seen, and it is not too near. Seen through: wholly in
    view, within the reliable range, and most of the lines of sight through its middle half returned something that lies beyond
    its centre by more than `tolerance_m` and two standard deviations `sigma_m` (n,). No return is no evidence.
    """
    camera = view.camera
    in_view, seen_through = np.empty(len(discs), np.bool_), np.empty(len(discs), np.bool_)
    _look(
        discs,
        sigma_m,
        float(camera.position_ned_m[0]),
        float(camera.position_ned_m[1]),
        camera.heading_rad,
        float(camera.level[0, 2]),
        np.ascontiguousarray(view.seen),
        np.ascontiguousarray(view.furthest_m),
        view.range_min_m,
        view.reliable_range_m,
        tolerance_m,
        in_view,
        seen_through,
    )
    return in_view, seen_through


@njit("i8(f8)", cache=True, nogil=True, error_model="numpy")
def _bin_of(bearing):  # type: ignore[no-untyped-def]
    """Bearing bin of the cell grid."""
    tangent = math.tan(min(max(bearing, -BEARING_MAX_RAD), BEARING_MAX_RAD))
    return min(max(math.floor((tangent + TANGENT_MAX) / TANGENT_STEP), 0), TANGENT_BINS - 1)


@njit("b1(b1[::1],f8)", cache=True, nogil=True, error_model="numpy")
def _is_seen(seen, bearing):  # type: ignore[no-untyped-def]
    """Whether a bearing relative to the heading lies in a seen sector; they span the half circle ahead."""
    sector = math.floor((bearing + math.pi / 2) / (math.pi / seen.shape[0]))
    return 0 <= sector < seen.shape[0] and seen[sector]


@njit(_LOOK, cache=True, nogil=True, error_model="numpy")
def _look(  # type: ignore[no-untyped-def]
    discs, sigma_m, camera_north, camera_east, heading, depth_per_ahead, seen, furthest_m, range_min, reliable_range, tolerance,
    in_view, seen_through,
):  # fmt: skip
    cos, sin = math.cos(heading), math.sin(heading)
    for j in range(discs.shape[0]):
        north, east, radius = discs[j, 0] - camera_north, discs[j, 1] - camera_east, discs[j, 2]
        ahead, aside = north * cos + east * sin, east * cos - north * sin
        distance = math.hypot(ahead, aside)
        bearing = math.atan2(aside, ahead)
        half = math.asin(min(radius / max(distance, 1e-6), 1.0))
        in_view[j] = (
            distance - radius > range_min
            and _is_seen(seen, bearing - half)
            and _is_seen(seen, bearing)
            and _is_seen(seen, bearing + half)
        )
        seen_through[j] = False
        if not in_view[j] or ahead * depth_per_ahead >= reliable_range:
            continue
        first, last = _bin_of(bearing - half / 2), _bin_of(bearing + half / 2)
        wanted_m = ahead + tolerance + 2.0 * sigma_m[j]
        beyond = 0
        for k in range(first, last + 1):
            if furthest_m[k] > wanted_m:
                beyond += 1
        seen_through[j] = beyond > _SEEN_THROUGH_FRACTION * (last + 1 - first)
