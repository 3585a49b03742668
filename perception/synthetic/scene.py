"""A known scene: what stands on flat ground. Mission frame (north, east, down), metres."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.float64]


class SceneLike(Protocol):
    """What the renderer needs to know of a world; see `Scene`."""

    @property
    def ground_down_m(self) -> float: ...
    @property
    def cylinders(self) -> Rows: ...
    @property
    def boxes(self) -> Rows: ...
    @property
    def capsules(self) -> Rows: ...


@dataclass(frozen=True, slots=True)
class Scene:
    """Vertical cylinders and boxes on the ground plane at `ground_down_m`; capsules anywhere: branches, wires, leaning poles.

    cylinders: (n, 4) north_m, east_m, radius_m, height_m. boxes: (m, 6) north_m, east_m, length_m (along the heading), width_m,
    height_m, heading_rad. capsules: (k, 7) north_m, east_m, down_m of one end, of the other end, radius_m.
    """

    cylinders: Rows = field(default_factory=lambda: np.zeros((0, 4)))
    boxes: Rows = field(default_factory=lambda: np.zeros((0, 6)))
    ground_down_m: float = 0.0
    capsules: Rows = field(default_factory=lambda: np.zeros((0, 7)))
