"""The protected boundary in the forms that the planner's parts take, made once for as long as the boundary is the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, Boundary
from flightapp.planning.plane import Segment, segments


@dataclass(frozen=True, slots=True)
class Edge:
    """`boundary` as its sides: tuples of points, and rows (s, 4: north, east of both ends) in m."""

    boundary: Boundary
    sides: tuple[Segment, ...]
    rows: Array

    @classmethod
    def of(cls, boundary: Boundary) -> Edge:
        """The sides of `boundary`."""
        sides = segments(boundary)
        return cls(boundary, sides, np.array(sides, dtype=np.float64).reshape(-1, 4))


NO_EDGE = Edge.of(Boundary(np.zeros((0, 2)), False))
