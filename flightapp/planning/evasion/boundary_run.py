"""Where the boundary is nearest, and whether the evader has crossed it."""

from __future__ import annotations

import math

from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array, Observation
from flightapp.planning.ac2f.edge import NO_EDGE, Edge
from flightapp.planning.boundary import is_crossed
from flightapp.planning.plane import Point, planar, towards

AT_THE_GOAL_M = 0.5
"""So near, the direction to the goal means nothing: the last one is kept."""


@compiled("UniTuple(f8,2)(f8[:,::1],f8,f8)")
def nearest_on_sides(sides: Array, n: float, e: float) -> Point:
    """The point of `sides` (s, 4) nearest to (n, e)."""
    best = math.inf
    best_n = n
    best_e = e
    for i in range(sides.shape[0]):
        dn = sides[i, 2] - sides[i, 0]
        de = sides[i, 3] - sides[i, 1]
        fraction = nearest_share(sides[i, 0] - n, sides[i, 1] - e, dn, de)
        side_n = sides[i, 0] + fraction * dn
        side_e = sides[i, 1] + fraction * de
        distance = math.hypot(side_n - n, side_e - e)
        if distance < best:
            best = distance
            best_n = side_n
            best_e = side_e
    return best_n, best_e


class BoundaryRun:
    """The way to the boundary, remembered from step to step."""

    def __init__(self) -> None:
        self._before: Point | None = None
        self._direction: Point = (0.0, 0.0)
        self.edge = NO_EDGE
        self.crossed = False

    def goal(self, observation: Observation) -> Point:
        """The nearest point of the boundary (m); notes a crossing since the last call."""
        own = planar(observation.own.position_ned_m)
        if observation.boundary is not self.edge.boundary:
            self.edge = Edge.of(observation.boundary)
        if self._before is not None:
            self.crossed = self.crossed or is_crossed(self.edge.rows, *self._before, *own)
        self._before = own
        return nearest_on_sides(self.edge.rows, *own)

    def direction(self, own: Point, goal: Point) -> Point:
        """Unit vector to `goal`; the last one while the goal is at hand."""
        if math.dist(own, goal) > AT_THE_GOAL_M:
            self._direction = towards(own, goal)
        return self._direction
