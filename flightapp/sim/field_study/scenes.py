"""The paper's three kinds of scenes, and the random ones of the success rate.

The source's x, y, z are north, east and minus down here. Its start and goal tables are blank: (0, 0, 0) and (10, 10, 10) follow
from the places of obstacles next to the goal and on the diagonal. It states no radii for the first two: 0.5 m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.adaptive_apf.paper_step import STEP_S
from flightapp.space.bodies import V_NORTH
from flightapp.space.shapes import Sphere, bodies_of

RADIUS_M = 0.5
BETWEEN = ((2.0, 2.5, 2.5), (1.3, 2.0, 1.4), (2.5, 1.0, 1.1), (3.3, 2.0, 2.1), (7.0, 7.2, 7.0), (8.0, 8.0, 8.0))
UNREACHABLE = ((1.0, 0.5, 0.5), *BETWEEN, (10.0, 9.5, 9.1))
"""Table 2: the last obstacle stands beside the goal."""
MINIMUM = ((0.5, 0.5, 0.5), *BETWEEN, (9.0, 9.5, 9.1))
"""Table 4: the first stands before the start."""
STATIC = (((4.0, 5.0, 4.0), 1.0), ((8.0, 9.0, 9.0), 0.0), ((11.0, 15.0, 13.0), 1.3), ((14.0, 11.0, 6.0), 2.0))
MOVING = (((6.0, 11.0, 7.0), 2.0, (0.02, 0.03, 0.04)), ((12.0, 12.0, 14.0), 2.0, (-0.03, 0.05, 0.03)))
"""Tables 5 and 6: centre, radius, and metres a step."""
PERIOD = 100.0
"""Steps after which a moving obstacle turns back."""
JITTER_M = 1.5
"""Of every centre along each axis, in the random scenes."""


@dataclass(frozen=True, slots=True)
class FieldScene:
    """bodies (n, BODY_COLUMNS) where they are at the start, and how many steps each has moved since it turned."""

    name: str
    bodies: Array
    phases: Array
    start_ned_m: Array
    goal_ned_m: Array

    @property
    def moves(self) -> bool:
        """Whether any body does."""
        return bool(self.bodies[:, V_NORTH:].any())


def _standing(name: str, places: tuple[tuple[float, float, float], ...]) -> FieldScene:
    bodies = bodies_of([Sphere(x, y, -z, RADIUS_M) for x, y, z in places])
    return FieldScene(name, bodies, np.zeros(len(places)), np.zeros(3), np.array((10.0, 10.0, -10.0)))


def unreachable_target() -> FieldScene:
    return _standing("unreachable target (table 2)", UNREACHABLE)


def local_minimum() -> FieldScene:
    return _standing("local minimum (table 4)", MINIMUM)


def moving_obstacles(seed: int | None = None) -> FieldScene:
    """Tables 5 and 6; with a seed every centre is moved by up to JITTER_M an axis and the phases are random."""
    generator = np.random.default_rng(seed)
    shapes, phases = [], []
    bodies: list[tuple[tuple[float, float, float], float, tuple[float, float, float]]] = [
        *((centre, radius, (0.0, 0.0, 0.0)) for centre, radius in STATIC),
        *MOVING,
    ]
    for centre, radius, step in bodies:
        x, y, z = np.array(centre) + (0.0 if seed is None else generator.uniform(-JITTER_M, JITTER_M, 3))
        begun = 0.0 if seed is None else float(generator.integers(0, 2 * int(PERIOD)))
        forth = begun < PERIOD
        moved = begun if forth else 2.0 * PERIOD - begun
        vx, vy, vz = step
        sign = 1.0 if forth else -1.0
        velocity = (sign * vx / STEP_S, sign * vy / STEP_S, -sign * vz / STEP_S)
        shapes.append(Sphere(x + moved * vx, y + moved * vy, -(z + moved * vz), radius, velocity))
        phases.append(begun if forth else begun - PERIOD)
    name = "moving obstacles (tables 5, 6)" if seed is None else f"random {seed}"
    return FieldScene(name, bodies_of(shapes), np.array(phases), np.zeros(3), np.array((19.0, 19.0, -19.0)))
