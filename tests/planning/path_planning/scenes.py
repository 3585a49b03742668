"""Problems that the tests of path planning share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flightapp.planning.path_planning.api import Problem
from flightapp.planning.path_planning.trajectory import FlightLimits
from flightapp.space.random_scene import random_scene
from flightapp.space.shapes import OrientedBox, Shape
from flightapp.space.world import World

GAP_M = 2.25
LIMITS = FlightLimits(speed_max_m_s=10.0, climb_rate_max_m_s=5.0, acceleration_max_m_s2=6.0)


def scene_problem(seed: int, way: str = "level") -> Problem:
    """The paper's scene `seed`."""
    scene = random_scene(seed, way)
    return Problem(World.of(scene.shapes), scene.start_ned_m, scene.goal_ned_m, scene.low_ned_m, scene.high_ned_m, GAP_M, GAP_M)


def room(
    shapes: Sequence[Shape], start: tuple[float, float, float], goal: tuple[float, float, float], gap_m: float = 1.0
) -> Problem:
    """A room of 40 m x 40 m x 10 m above the ground."""
    low, high = np.array((-20.0, -20.0, -10.0)), np.array((20.0, 20.0, 0.0))
    return Problem(World.of(shapes), np.array(start), np.array(goal), low, high, gap_m, gap_m)


WALL = OrientedBox(0.0, -4.0, 1.0, 32.0, -20.0, 1.0)
"""Across the room from its west side, with an opening of 8 m in the east."""
