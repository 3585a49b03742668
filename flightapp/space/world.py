"""A world of bodies as Python code asks it; kernels read `bodies` and `cells` themselves."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.space.bodies import V_DOWN, V_NORTH
from flightapp.space.broad_phase import Cells, sort_into_cells
from flightapp.space.contact import first_contact
from flightapp.space.distance import all_gaps, nearest_bodies, signed_distance, signed_distance_and_gradient
from flightapp.space.shapes import Shape, bodies_of
from flightapp.space.way import is_way_free

REACH_M = 12.0
"""Of the broad phase: farther than any clearance that is asked of a way."""


@dataclass(frozen=True, slots=True)
class Contact:
    """The first touch of a flying ball and a body."""

    t_s: float
    """Counted from the start of the flight."""
    body: int
    """Row of the body."""


@dataclass(frozen=True, slots=True)
class World:
    """Bodies as rows (n, BODY_COLUMNS), at their places at time zero, and those at rest sorted into a broad phase."""

    bodies: Array
    resting: Array
    """Rows of the bodies without velocity, which `cells` refers to; in an order that does not depend on theirs in `bodies`."""
    moving: Array
    cells: Cells

    @classmethod
    def of(cls, shapes: Iterable[Shape], reach_m: float = REACH_M) -> World:
        return cls.of_bodies(bodies_of(shapes), reach_m)

    @classmethod
    def of_bodies(cls, bodies: Array, reach_m: float = REACH_M) -> World:
        moves = (bodies[:, V_NORTH : V_DOWN + 1] != 0.0).any(axis=1)
        resting = _in_order(bodies[~moves])
        return cls(bodies, resting, _in_order(bodies[moves]), sort_into_cells(resting, reach_m))

    def signed_distance_m(self, point_ned_m: Array, t_s: float = 0.0) -> float:
        """From a point (3,) to the nearest body at `t_s`; negative inside; NO_OBSTACLE_M in an empty world."""
        return signed_distance(self.bodies, *_numbers(point_ned_m), t_s)

    def signed_distance_and_gradient(self, point_ned_m: Array, t_s: float = 0.0) -> tuple[float, Array]:
        """The same, and the unit vector (3,) away from that body; zeros in an empty world."""
        distance, *gradient = signed_distance_and_gradient(self.bodies, *_numbers(point_ned_m), t_s)
        return distance, np.array(gradient)

    def gaps(self, point_ned_m: Array, t_s: float = 0.0) -> Array:
        """(n, 4): signed distance of a point (3,) to every body, and the gradient."""
        gaps = np.empty((len(self.bodies), 4))
        all_gaps(self.bodies, *_numbers(point_ned_m), t_s, gaps)
        return gaps

    def resting_distance_m(self, point_ned_m: Array) -> float:
        """Signed distance to the nearest body at rest."""
        return signed_distance(self.resting, *_numbers(point_ned_m), 0.0)

    def resting_distance_and_gradient(self, point_ned_m: Array) -> tuple[float, Array]:
        """The same, and the unit vector (3,) away from it."""
        distance, *gradient = signed_distance_and_gradient(self.resting, *_numbers(point_ned_m), 0.0)
        return distance, np.array(gradient)

    def moving_distance_m(self, point_ned_m: Array, t_s: float) -> float:
        """Signed distance to the nearest moving body at `t_s`."""
        return signed_distance(self.moving, *_numbers(point_ned_m), t_s)

    def nearest(
        self, point_ned_m: Array, count: int, t_s: float = 0.0, within_m: float = math.inf
    ) -> tuple[NDArray[np.int64], Array]:
        """Rows (k,) of the at most `count` nearest bodies, nearest first, and their (k, 4) as `gaps` has them."""
        which, gaps = np.empty(count, dtype=np.int64), np.empty((count, 4))
        found = nearest_bodies(self.bodies, *_numbers(point_ned_m), t_s, within_m, which, gaps)
        return which[:found], gaps[:found]

    def is_way_free(self, start_ned_m: Array, end_ned_m: Array, gap_m: float) -> bool:
        """Whether the straight way keeps `gap_m` from every body at rest, all along; ValueError beyond the world's reach."""
        if gap_m >= self.cells.reach_m - 1.0:
            raise ValueError(f"gap_m = {gap_m}: must stay below the world's reach, {self.cells.reach_m:g} m, less 1 m")
        along = np.asarray(end_ned_m, dtype=np.float64) - start_ned_m
        return is_way_free(self.resting, self.cells, *_numbers(start_ned_m), *_numbers(along), gap_m)

    def first_contact(
        self, point_ned_m: Array, velocity_ned_m_s: Array, radius_m: float, horizon_s: float, start_s: float = 0.0
    ) -> Contact | None:
        """Of a ball that flies straight on from a point (3,), with any body, resting or moving; None not within the horizon."""
        flown = (*_numbers(point_ned_m), *_numbers(velocity_ned_m_s))
        t_s, body = first_contact(self.bodies, *flown, start_s, radius_m, horizon_s)
        return None if body < 0 else Contact(t_s, body)


def _in_order(bodies: Array) -> Array:
    return np.ascontiguousarray(bodies[np.lexsort(bodies.T[::-1])])


def _numbers(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
