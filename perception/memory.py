"""Short-term memory of discs in the mission frame: what has left the view is still there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.parameters import PerceptionParameters
from perception.sectors import is_seen
from perception.sighting import View

_CAPACITY = 300
_SEE_THROUGH_FRACTION = 0.5
_CONTAINED_M = 0.2
"""A disc that sticks out of another by less than this counts as contained in it."""
_BEARING_MAX_RAD = 1.3


class DiscMemory:
    """Discs seen within the last `memory_s`, each with its radius as last seen."""

    def __init__(self, parameters: PerceptionParameters) -> None:
        self._parameters = parameters
        self.clear()

    def clear(self) -> None:
        self._discs = np.zeros((0, 3))
        self._seen_s = np.zeros(0)

    def update(
        self, t_s: float, observed: NDArray[np.float64], view: View | None, exclude: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Discs (n, 3) north_m, east_m, radius_m at `t_s`: the observed ones, then the remembered ones.

        observed: (m, 3) discs of this frame. view: what the frame showed, None if it showed nothing (then nothing can be seen to
        be free). exclude: (k, 3) north, east, radius of vehicles; nothing is remembered where one is.
        """
        if len(self._seen_s) and t_s < self._seen_s.max() - self._parameters.memory_s:
            self.clear()
        age_s = t_s - self._seen_s
        keep = age_s <= self._parameters.memory_s
        if len(exclude):
            gap = np.hypot(self._discs[:, :1] - exclude[:, 0], self._discs[:, 1:2] - exclude[:, 1])
            keep &= ~(gap <= exclude[:, 2]).any(axis=1)
        self._discs, self._seen_s = self._discs[keep], self._seen_s[keep]
        if view is not None and len(self._discs):
            observed = self._reconcile(t_s, observed, view)
        grown = self._discs.copy()
        grown[:, 2] += self._parameters.memory_growth_m_s * np.maximum(t_s - self._seen_s, 0.0)
        out = np.concatenate([observed, grown])
        if self._parameters.memory_s > 0:
            self._discs = np.concatenate([observed, self._discs])[:_CAPACITY]
            self._seen_s = np.concatenate([np.full(len(observed), t_s), self._seen_s])[:_CAPACITY]
        return out

    def _reconcile(self, t_s: float, observed: NDArray[np.float64], view: View) -> NDArray[np.float64]:
        """Forget what this frame replaces or shows to be gone; returns the observed discs that are not known better already.

        At the edge of the view an obstacle is cut off and its disc too small: there the disc that contains the other one stays,
        whichever it is. Discs wholly in view are replaced by what is observed, or dropped if one looks through them.
        """
        sight = _Sight(self._discs, view)
        gone = np.zeros(len(self._discs), np.bool_)
        known = np.zeros(len(observed), np.bool_)
        if len(observed):
            gap = np.hypot(self._discs[:, :1] - observed[:, 0], self._discs[:, 1:2] - observed[:, 1])
            growth = observed[:, 2] - self._discs[:, 2:]
            gone |= (gap <= growth + _CONTAINED_M).any(axis=1)
            gone |= sight.whole & (gap <= self._parameters.association_m + np.maximum(growth, 0.0)).any(axis=1)
        for i in np.flatnonzero(sight.whole & ~gone & (sight.depth_m < view.reliable_range_m)):
            gone[i] = sight.goes_on_beyond(int(i), self._parameters.surface_tolerance_m)
        if len(observed):
            contained = (gap <= _CONTAINED_M - growth) & ~gone[:, None] & ~_Sight(observed, view).whole
            known |= contained.any(axis=0)
            self._seen_s[contained.any(axis=1)] = t_s
        self._discs, self._seen_s = self._discs[~gone], self._seen_s[~gone]
        return observed[~known]


class _Sight:
    """Discs as the camera sees them. whole: (n,) wholly in a seen sector. depth_m: (n,) of the centre along the optical axis."""

    def __init__(self, discs: NDArray[np.float64], view: View) -> None:
        camera = view.camera
        north, east = discs[:, 0] - camera.position_ned_m[0], discs[:, 1] - camera.position_ned_m[1]
        cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
        self._ahead, aside = north * cos + east * sin, east * cos - north * sin
        self._nearest_m = view.nearest_m
        distance = np.hypot(self._ahead, aside)
        self._bearing = np.arctan2(aside, self._ahead)
        self._half = np.arcsin(np.minimum(discs[:, 2] / np.maximum(distance, 1e-6), 1.0))
        self.depth_m = self._ahead * float(camera.level[0, 2])
        self.whole: NDArray[np.bool_] = (
            is_seen(view.seen, self._bearing - self._half)
            & is_seen(view.seen, self._bearing)
            & is_seen(view.seen, self._bearing + self._half)
            & (distance - discs[:, 2] > view.range_min_m)
        )

    def goes_on_beyond(self, i: int, tolerance_m: float) -> bool:
        """Whether most of the lines of sight to disc `i` go on beyond its centre."""
        bearing, half = float(self._bearing[i]), float(self._half[i])
        surface_m = self._nearest_m[_bin_of(bearing - half / 2) : _bin_of(bearing + half / 2) + 1]
        beyond = np.count_nonzero(surface_m > self._ahead[i] + tolerance_m)
        return bool(beyond > _SEE_THROUGH_FRACTION * len(surface_m))


def _bin_of(bearing_rad: float) -> int:
    """Bearing bin of the cell grid, relative to the camera's heading."""
    tangent = math.tan(min(max(bearing_rad, -_BEARING_MAX_RAD), _BEARING_MAX_RAD))
    return min(max(int((tangent + TANGENT_MAX) / TANGENT_STEP), 0), TANGENT_BINS - 1)
