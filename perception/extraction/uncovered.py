"""Surfaces that no disc stands for: their bearings must not count as seen.

A disc may be smaller than what it stands for at its rim, something cut by the picture's edge may go on beyond its disc, and of
many discs only the nearest go out. Whoever flies by discs and unseen sectors must meet one or the other wherever something is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP, bins_of_sectors
from perception.extraction.surfaces import SurfacePoints
from perception.kernel_cache import njit

_BEHIND_M = 0.3
_BEHIND_SIGMAS = 3.0
"""A surface this far behind the front of a disc is what the disc stands for, or hidden by it."""


class UncoveredSurfaces:
    """Compares surfaces with discs; holds its buffers."""

    def __init__(self, noise_1_m: float) -> None:
        self._noise_1_m = noise_1_m
        self._surface_m = np.zeros(TANGENT_BINS)
        self._bins_of = bins_of_sectors()
        self._sectors = np.zeros(len(self._bins_of), np.bool_)

    def sectors(self, points: SurfacePoints, discs: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(360,) half-degree sectors ahead in which a surface stands before every disc. discs: (n, 3) forward, right, radius."""
        _find_uncovered(
            points.forward_m,
            points.bin,
            np.ascontiguousarray(discs),
            self._noise_1_m,
            self._surface_m,
            self._bins_of,
            self._sectors,
        )
        return self._sectors


@njit("void(f8[::1],i4[::1],f8[:,::1],f8,f8[::1],i4[:,::1],b1[::1])", cache=True, nogil=True, error_model="numpy")
def _find_uncovered(forward, bins, discs, noise, surface, bins_of, sectors):  # type: ignore[no-untyped-def]
    surface[:] = np.inf
    for i in range(forward.shape[0]):
        surface[bins[i]] = min(surface[bins[i]], forward[i])
    for b in range(surface.shape[0]):
        if surface[b] == np.inf:
            continue
        tangent = (b + 0.5) * TANGENT_STEP - TANGENT_MAX
        per_forward = np.sqrt(1.0 + tangent * tangent)
        distance = surface[b] * per_forward
        limit = distance + _BEHIND_M + _BEHIND_SIGMAS * noise * surface[b] * surface[b]
        for k in range(discs.shape[0]):
            ahead, aside, radius = discs[k, 0], discs[k, 1], discs[k, 2]
            across = (aside - tangent * ahead) / per_forward
            if abs(across) <= radius:
                along = (ahead + tangent * aside) / per_forward
                if along - np.sqrt(radius * radius - across * across) <= limit:
                    surface[b] = np.inf
                    break
    for sector in range(sectors.shape[0]):
        sectors[sector] = False
        for b in range(bins_of[sector, 0], bins_of[sector, 1] + 1):
            sectors[sector] |= surface[b] < np.inf
