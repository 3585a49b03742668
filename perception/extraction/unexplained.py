"""Returns that became no surface although they are near: their bearings must not count as seen.

Two kinds. Returns within the height band from nearer than the first surface found in their bearing, too many for speckle: too
small a part of something shows, because the picture's edge or a hole cuts it off, or too few pixels at the rim of a glare. And
something that stands right below the band and neither goes on into it nor is overlooked by returns from beyond: its upper part
is hidden by what returns nothing. The price: the top of a bush less than half a metre below the band, with nothing but the sky
behind it, hides its bearing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import SECTORS, TANGENT_BINS, bins_of_sectors
from perception.extraction.blindness import REACH_STEP_M, Evidence
from perception.kernel_cache import njit

_STANDING_MIN = 6
"""A wrong match of stereo is up to six pixels wide and high: up to four samples, one in four rows and columns."""
_BELOW_MIN = 4
_TOLERANCE_M = 0.3
_TOLERANCE_SIGMAS = 4.0


class UnexplainedReturns:
    """Compares what returned with what was found; holds its buffers."""

    def __init__(self, noise_1_m: float, reliable_range_m: float) -> None:
        self._noise_1_m = noise_1_m
        self._reliable_range_m = reliable_range_m
        self._is_unexplained = np.zeros(TANGENT_BINS, np.bool_)
        self._sectors = np.zeros(SECTORS, np.bool_)
        self._bins_of = bins_of_sectors()

    def sectors(self, evidence: Evidence, nearest_m: NDArray[np.float64], along_axis: float) -> NDArray[np.bool_]:
        """(360,) half-degree sectors ahead with such returns.

        nearest_m: (TANGENT_BINS,) forward distance of the first surface. along_axis: depth per metre forward.
        """
        _find_unexplained(
            evidence.standing,
            along_axis,
            self._noise_1_m,
            self._reliable_range_m,
            nearest_m,
            evidence.furthest_m,
            evidence.below,
            evidence.below_m,
            self._bins_of,
            self._is_unexplained,
            self._sectors,
        )
        return self._sectors


@njit(
    "void(i4[:,::1],f8,f8,f8,f8[::1],f8[::1],i4[::1],f8[::1],i4[:,::1],b1[::1],b1[::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _find_unexplained(  # type: ignore[no-untyped-def]
    standing, along_axis, noise, reliable, nearest, furthest, below, below_m, bins_of, is_unexplained, sectors
):
    bins = nearest.shape[0]
    is_unexplained[:] = False
    for b in range(bins):
        first, end = max(b - 1, 0), min(b + 2, bins)
        found, low, low_m = np.inf, 0, np.inf
        for k in range(first, end):
            found = min(found, nearest[k])
            low += below[k]
            low_m = min(low_m, below_m[k])
        near = 0
        for reach in range(standing.shape[1]):
            end_m = (reach + 1) * REACH_STEP_M
            depth = end_m * along_axis
            if depth >= reliable or end_m + _TOLERANCE_M + _TOLERANCE_SIGMAS * noise * depth * depth >= found:
                break
            for k in range(first, end):
                near += standing[k, reach]
        if near >= _STANDING_MIN:
            is_unexplained[first:end] = True
        if low > 0 and low + near >= _BELOW_MIN:
            limit = low_m + _TOLERANCE_M + _TOLERANCE_SIGMAS * noise * low_m * low_m
            if found > limit and furthest[b] <= limit:
                is_unexplained[first:end] = True
    for sector in range(sectors.shape[0]):
        sectors[sector] = False
        for b in range(bins_of[sector, 0], bins_of[sector, 1] + 1):
            sectors[sector] |= is_unexplained[b]
