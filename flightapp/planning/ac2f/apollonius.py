"""The interception game on Apollonius circles (Zhang et al. 2026, section 4, with the intersection instead of the union).

A pursuer leaves the evader the points that the evader reaches no later: |p - p_i| >= lambda_i |p - p_e|. What all pursuers
together leave it is its dominance region. The game point is the point of this region nearest to the protected boundary.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.ac2f.apollonius_kernel import HALF_PLANE, REGION_COLUMNS, solve_game
from flightapp.planning.plane import Point


@dataclass(frozen=True, slots=True)
class Game:
    """Solution for all k pursuers: the game point, who is active there, and the goal of each pursuer.

    regions: (k, 6), one row a pursuer as in `apollonius_kernel`. active: (k,) 1 or 0. goals: (k, 2) m.
    """

    point: Point
    contested: bool
    distance_m: float
    active: Array
    goals: Array
    regions: Array

    def circles(self) -> list[list[float]]:
        """Rows north_m, east_m, radius_m of the regions that are no half-planes."""
        return [row[1:4] for row in self.regions.tolist() if row[0] != HALF_PLANE]


def solve(
    pursuers: Sequence[Point],
    evader: Point,
    speed_ratios: Sequence[float],
    sides: Array,
    *,
    closed: bool = False,
    union: bool = False,
    goal_spacing_m: float = 3.0,
) -> Game:
    """The game for `pursuers` (m) against `evader` before the boundary `sides` (s, 4); `goal_spacing_m` keeps goals apart.

    `union` is the source's literal reading: the point of the union of the regions that is nearest to the boundary.
    """
    count = len(pursuers)
    regions, active, goals = np.empty((count, REGION_COLUMNS)), np.empty(count), np.empty((count, 2))
    contested, north, east, distance_m = solve_game(
        np.array(pursuers, dtype=np.float64),
        evader[0],
        evader[1],
        np.array(speed_ratios, dtype=np.float64),
        sides,
        closed,
        union,
        goal_spacing_m,
        regions,
        active,
        goals,
    )
    return Game((north, east), contested, distance_m, active, goals, regions)
