"""Short-term memory of discs in the mission frame: what has left the view is still there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.cells import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.geometry import CameraPose
from perception.parameters import PerceptionParameters
from perception.sectors import is_seen

_CAPACITY = 300
_SEE_THROUGH_FRACTION = 0.5
_SAME_PLACE_M = 0.3
_BEARING_MAX_RAD = 1.3


@dataclass(frozen=True, slots=True)
class View:
    """What one frame showed.

    seen: (360,) half-degree sectors ahead that were seen. nearest_m: forward distance of the first surface in each bearing bin
    of the cell grid, inf where there is none. reliable_range_m: depth up to which no surface means free.
    """

    camera: CameraPose
    seen: NDArray[np.bool_]
    nearest_m: NDArray[np.float64]
    range_min_m: float
    reliable_range_m: float


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
        if view is not None and len(self._discs):
            keep &= ~self._superseded(observed, view)
        self._discs, self._seen_s = self._discs[keep], self._seen_s[keep]
        grown = self._discs.copy()
        grown[:, 2] += self._parameters.memory_growth_m_s * np.maximum(t_s - self._seen_s, 0.0)
        out = np.concatenate([observed, grown])
        if self._parameters.memory_s > 0:
            self._discs = np.concatenate([observed, self._discs])[:_CAPACITY]
            self._seen_s = np.concatenate([np.full(len(observed), t_s), self._seen_s])[:_CAPACITY]
        return out

    def _superseded(self, observed: NDArray[np.float64], view: View) -> NDArray[np.bool_]:
        """Which remembered discs this frame replaces or shows to be gone."""
        discs, camera = self._discs, view.camera
        north, east = discs[:, 0] - camera.position_ned_m[0], discs[:, 1] - camera.position_ned_m[1]
        cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
        ahead, aside = north * cos + east * sin, east * cos - north * sin
        distance, bearing = np.hypot(ahead, aside), np.arctan2(aside, ahead)
        half = np.arcsin(np.minimum(discs[:, 2] / np.maximum(distance, 1e-6), 1.0))
        wholly_in_view = (
            is_seen(view.seen, bearing)
            & is_seen(view.seen, bearing - half)
            & is_seen(view.seen, bearing + half)
            & (distance - discs[:, 2] > view.range_min_m)
        )
        gone = np.zeros(len(discs), np.bool_)
        if len(observed):
            gap = np.hypot(discs[:, :1] - observed[:, 0], discs[:, 1:2] - observed[:, 1])
            shrink = discs[:, 2:] - observed[:, 2]
            # A disc partly out of view gives way only to one in nearly the same place that is about as large.
            gone |= ((gap <= _SAME_PLACE_M) & (shrink <= _SAME_PLACE_M)).any(axis=1)
            reach = self._parameters.association_m + np.maximum(-shrink, 0.0)
            gone |= wholly_in_view & (gap <= reach).any(axis=1)
        depth = ahead * float(camera.level[0, 2])
        for i in np.flatnonzero(wholly_in_view & ~gone & (depth < view.reliable_range_m)):
            first, last = _bin_of(bearing[i] - half[i] / 2), _bin_of(bearing[i] + half[i] / 2) + 1
            sight = view.nearest_m[first:last] > ahead[i] + self._parameters.surface_tolerance_m
            gone[i] = np.count_nonzero(sight) > _SEE_THROUGH_FRACTION * len(sight)
        return gone


def _bin_of(bearing_rad: float) -> int:
    """Bearing bin of the cell grid, relative to the camera's heading."""
    tangent = math.tan(min(max(bearing_rad, -_BEARING_MAX_RAD), _BEARING_MAX_RAD))
    return min(max(int((tangent + TANGENT_MAX) / TANGENT_STEP), 0), TANGENT_BINS - 1)
