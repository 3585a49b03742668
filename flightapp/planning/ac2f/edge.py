"""The protected boundary as the kernels take it, made once for as long as the boundary is the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, Boundary
from flightapp.planning.plane import segments


@dataclass(frozen=True, slots=True)
class Edge:
    """`boundary` as rows of its sides (s, 4: north, east of both ends) in m."""

    boundary: Boundary
    rows: Array

    @classmethod
    def of(cls, boundary: Boundary) -> Edge:
        """The sides of `boundary`."""
        return cls(boundary, np.array(segments(boundary), dtype=np.float64).reshape(-1, 4))


NO_EDGE = Edge.of(Boundary(np.zeros((0, 2)), False))
