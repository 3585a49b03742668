"""Where the things of a scene truly are, as seen from above."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array

_SILHOUETTE = np.array([-0.9, -0.45, 0.0, 0.45, 0.9])
"""Where a body is looked at, across its line of sight in radii: its very edge is a matter of half a pixel."""
_ALONG = 9


@dataclass(frozen=True, slots=True)
class Body:
    """A line between two points, `radius_m` thick: a pole or a ball if both points are the same.

    ends_m: north, east of one end, north, east of the other.
    """

    ends_m: tuple[float, float, float, float]
    radius_m: float
    velocity_m_s: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def upright(cls, north_m: float, east_m: float, radius_m: float, velocity_m_s: tuple[float, float] = (0.0, 0.0)) -> Body:
        """A pole, a trunk or a ball."""
        return cls((north_m, east_m, north_m, east_m), radius_m, velocity_m_s)

    @property
    def is_round(self) -> bool:
        return self.ends_m[:2] == self.ends_m[2:]

    @property
    def centre_m(self) -> tuple[float, float]:
        return (self.ends_m[0] + self.ends_m[2]) / 2, (self.ends_m[1] + self.ends_m[3]) / 2

    def gap_m(self, points_m: Array) -> Array:
        """(n,) distance of points (n, 2) to the surface, negative inside."""
        start, end = np.array(self.ends_m[:2]), np.array(self.ends_m[2:])
        axis = end - start
        part = np.clip((points_m - start) @ axis / max(float(axis @ axis), 1e-12), 0.0, 1.0)
        gap: Array = np.hypot(*(points_m - start - part[:, None] * axis).T) - self.radius_m
        return gap

    def visible_points_m(self, viewer_m: Array) -> Array:
        """(k, 2) points of the surface that face the viewer (2,)."""
        start, end = np.array(self.ends_m[:2]), np.array(self.ends_m[2:])
        if self.is_round:
            offset = _SILHOUETTE * self.radius_m
            towards = viewer_m - start
            towards /= max(math.hypot(*towards), 1e-9)
            depth = np.sqrt(self.radius_m**2 - offset**2)
            front: Array = start + depth[:, None] * towards + offset[:, None] * np.array([-towards[1], towards[0]])
            return front
        line = start + np.linspace(0.03, 0.97, _ALONG)[:, None] * (end - start)
        towards_each = viewer_m - line
        towards_each /= np.maximum(np.hypot(*towards_each.T), 1e-9)[:, None]
        facing: Array = line + self.radius_m * towards_each
        return facing
