"""Short-term memory of discs in the mission frame: what has left the view is still there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.cells import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.geometry import CameraPose
from perception.parameters import PerceptionParameters
from perception.sectors import is_seen

_CAPACITY = 300
_SEE_THROUGH_FRACTION = 0.5


@dataclass(frozen=True, slots=True)
class View:
    """What one frame showed.

    seen: (360,) half-degree sectors ahead that were seen. nearest_m: forward distance of the first surface in each bearing bin
    of the cell grid, inf where there is none.
    """

    camera: CameraPose
    seen: NDArray[np.bool_]
    nearest_m: NDArray[np.float64]
    range_min_m: float
    range_max_m: float


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
        """Which remembered discs this frame replaces or shows to be gone. Only discs that are wholly in view can be either."""
        discs, camera = self._discs, view.camera
        north, east = discs[:, 0] - camera.position_ned_m[0], discs[:, 1] - camera.position_ned_m[1]
        cos, sin = np.cos(camera.heading_rad), np.sin(camera.heading_rad)
        ahead, aside = north * cos + east * sin, east * cos - north * sin
        distance, bearing = np.hypot(ahead, aside), np.arctan2(aside, ahead)
        half = np.arcsin(np.minimum(discs[:, 2] / np.maximum(distance, 1e-6), 1.0))
        in_view = (
            is_seen(view.seen, bearing)
            & is_seen(view.seen, bearing - half)
            & is_seen(view.seen, bearing + half)
            & (distance - discs[:, 2] > view.range_min_m)
        )
        reobserved = np.zeros(len(discs), np.bool_)
        if len(observed):
            gap = np.hypot(discs[:, :1] - observed[:, 0], discs[:, 1:2] - observed[:, 1])
            reach = self._parameters.association_m + np.maximum(discs[:, 2:], observed[:, 2])
            reobserved = (gap <= np.where(discs[:, 2:] > 1.5 * observed[:, 2], self._parameters.association_m, reach)).any(axis=1)
        return in_view & (reobserved | (self._seen_through(ahead, bearing, half, view) & (distance < view.range_max_m)))

    def _seen_through(
        self, ahead: NDArray[np.float64], bearing: NDArray[np.float64], half: NDArray[np.float64], view: View
    ) -> NDArray[np.bool_]:
        """Whether most of the lines of sight to a disc go on beyond its centre."""
        low = _bin_of(bearing - half / 2)
        high = np.maximum(_bin_of(bearing + half / 2), low) + 1
        beyond = np.zeros(len(ahead), np.bool_)
        for i, (first, last) in enumerate(zip(low, high, strict=True)):
            beyond[i] = (
                np.mean(view.nearest_m[first:last] > ahead[i] + self._parameters.surface_tolerance_m) > _SEE_THROUGH_FRACTION
            )
        return beyond


def _bin_of(bearing_rad: NDArray[np.float64]) -> NDArray[np.intp]:
    tangent = np.tan(np.clip(bearing_rad, -1.3, 1.3))
    return np.clip(((tangent + TANGENT_MAX) / TANGENT_STEP).astype(np.intp), 0, TANGENT_BINS - 1)
