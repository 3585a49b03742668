"""A polygon as the fence guards see it: which side a place lies on, how far each edge is, and which way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from flightapp.core.types import Array
from perception.kernel_cache import njit

ON_THE_LINE_M = 1e-6


class Edge(NamedTuple):
    """The nearest point of one edge: unit direction towards it (on the line: outwards), and its distance."""

    north: float
    east: float
    distance_m: float


class Look(NamedTuple):
    """What is seen of an outline from one place: all edges near it and the nearest of all. On the line counts as inside."""

    is_inside: bool
    nearest: Edge
    near: list[Edge]

    @property
    def inside_m(self) -> float:
        """Distance to the outline: positive inside, negative outside."""
        return self.nearest.distance_m if self.is_inside else -self.nearest.distance_m


class Outline:
    """A simple polygon of the mission frame (north, east), convex or not, in either direction."""

    def __init__(self, vertices_m: Sequence[tuple[float, float]]) -> None:
        corners = np.array(vertices_m, dtype=np.float64).reshape(-1, 2)
        following = np.roll(corners, -1, axis=0)
        turn = 1.0 if float(np.sum(corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1])) > 0.0 else -1.0
        lengths = np.hypot(*(following - corners).T)
        kept = lengths > 0.0
        along = (following - corners)[kept] / lengths[kept, None]
        self._edges = np.column_stack((corners[kept], along, lengths[kept], turn * along[:, 1], -turn * along[:, 0]))

    def seen_from(self, north_m: float, east_m: float, within_m: float) -> Look:
        """The look from a place in the mission frame; `near` holds the edges nearer than `within_m`."""
        rows, count, nearest, inside = _look(self._edges, north_m, east_m, within_m)
        near = [Edge(*row) for row in rows[:count].tolist()]
        return Look(bool(inside) or nearest[2] <= ON_THE_LINE_M, Edge(*nearest), near)


@njit("Tuple((f8[:,::1],i8,UniTuple(f8,3),b1))(f8[:,::1],f8,f8,f8)", cache=True)
def _look(edges: Array, north: float, east: float, within: float) -> tuple[Array, int, tuple[float, float, float], bool]:
    """Rows (n, 3) of unit direction and distance of the edges nearer than `within`, how many, the nearest, inside or not.

    edges (n, 7): first corner, unit direction along, length, unit normal outwards. Inside is decided by crossings.
    """
    rows = np.empty((len(edges), 3))
    count, inside = 0, False
    best_n, best_e, best = 1.0, 0.0, math.inf
    for index in range(len(edges)):
        n0, e0, along_n, along_e, length, out_n, out_e = edges[index]
        n1, e1 = n0 + length * along_n, e0 + length * along_e
        if (e0 > east) != (e1 > east) and north < n0 + (east - e0) * (n1 - n0) / (e1 - e0):
            inside = not inside
        along = min(max((north - n0) * along_n + (east - e0) * along_e, 0.0), length)
        to_n, to_e = n0 + along * along_n - north, e0 + along * along_e - east
        distance = math.hypot(to_n, to_e)
        if distance > ON_THE_LINE_M:
            to_n, to_e = to_n / distance, to_e / distance
        else:
            to_n, to_e = out_n, out_e
        if distance < best:
            best_n, best_e, best = to_n, to_e, distance
        if distance < within:
            rows[count, 0], rows[count, 1], rows[count, 2] = to_n, to_e, distance
            count += 1
    return rows, count, (best_n, best_e, best), inside
