"""What a path planner is asked and what it answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from flightapp.core.types import Array
from flightapp.space.world import World

Given = Mapping[str, object] | None


@dataclass(frozen=True, slots=True)
class Problem:
    """A way from start to goal (3,) within the box from low to high (3,), all NED in m.

    Every point of the way keeps `gap_m` from the bodies at rest and `moving_gap_m` from those that move, as their rows predict
    them from time zero, when the vehicle starts with `speed_m_s`.
    """

    world: World
    start_ned_m: Array
    goal_ned_m: Array
    low_ned_m: Array
    high_ned_m: Array
    gap_m: float
    moving_gap_m: float
    speed_m_s: float = 0.0
    speed_max_m_s: float = 10.0
    acceleration_max_m_s2: float = 6.0


def always() -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Budget:
    """When to stop looking for a better way: after so many iterations, or once `may_go_on` says no (a deadline, say)."""

    iterations: int
    may_go_on: Callable[[], bool] = field(default=always)


@dataclass(frozen=True, slots=True)
class Path:
    """points_ned_m (k, 3): from start to goal; empty where none was found, for the `reason`.

    nearest_ned_m (j, 3): then the way to the place nearest to the goal that was reached.
    """

    points_ned_m: Array
    iterations: int
    reason: str = ""
    nearest_ned_m: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def found(self) -> bool:
        return len(self.points_ned_m) > 0

    @property
    def length_m(self) -> float:
        """Length in m; inf where there is no way."""
        return way_length_m(self.points_ned_m) if self.found else float("inf")


class PathPlanner(Protocol):
    """Pure: the same problem, budget of iterations and seed give the same path; only OMPL's keep random numbers of their own."""

    def plan(self, problem: Problem, budget: Budget, seed: int) -> Path:
        """The best path within the budget. Start and goal must be free (`ends.put_right`)."""
        ...


def way_length_m(points: Array) -> float:
    """Length of the polyline (k, 3)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
