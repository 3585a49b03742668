"""Random obstacle scenes of the paper of RRT*-APF (specification 2.2): cylinders and boxes, centres by Poisson disk.

The paper has x, y, z with z up; here x is north, y is east and z is -down. Random numbers depend on nothing but the seed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.errors import InputError
from flightapp.core.types import Array
from flightapp.space.shapes import Cylinder, OrientedBox, Shape

SIDE_M = 100.0
FREE_COLUMN_M = 12.0
"""Around start and goal, from their axes to the nearest surface."""
TRIES = 10_000


@dataclass(frozen=True, slots=True)
class Scene:
    """What a path planner is asked: a way from start to goal (3,) within a box, past bodies. NED, m."""

    name: str
    shapes: tuple[Shape, ...]
    low_ned_m: Array
    high_ned_m: Array
    start_ned_m: Array
    goal_ned_m: Array


PAPER_WAYS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "level": ((0.0, 0.0, 30.0), (100.0, 100.0, 30.0)),
    "descent": ((0.0, 0.0, 100.0), (100.0, 100.0, 0.0)),
    "climb": ((0.0, 0.0, 0.0), (100.0, 100.0, 100.0)),
}
"""Of figures 13, 14 and 15: start and goal as x, y, z (up)."""
PAPER_SEEDS = (11, 29, 47)


def random_scene(seed: int, way: str = "level", obstacles: int = 17, spacing_m: float | None = None) -> Scene:
    """Scene `seed` with the start and goal of `way`; InputError where so many obstacles do not fit.

    spacing_m: between centres; None: 20, as in the paper, and 16 from 20 obstacles on, since about 22 fit at 20 m.
    """
    if way not in PAPER_WAYS:
        raise InputError(f"way = '{way}': no such way; known: {', '.join(PAPER_WAYS)}")
    spacing = spacing_m if spacing_m is not None else (20.0 if obstacles < 20 else 16.0)
    generator = np.random.default_rng(seed)
    start, goal = (np.array((x, y, -z)) for x, y, z in PAPER_WAYS[way])
    shapes: list[Shape] = []
    centres: list[Array] = []
    for _ in range(TRIES):
        if len(shapes) == obstacles:
            break
        centre = generator.uniform(0.0, SIDE_M, 2)
        shape, radius = _shape(centre, generator)
        if any(math.dist(centre, other) < spacing for other in centres):
            continue
        if min(math.dist(centre, start[:2]), math.dist(centre, goal[:2])) < FREE_COLUMN_M + radius:
            continue
        centres.append(centre)
        shapes.append(shape)
    if len(shapes) < obstacles:
        raise InputError(
            f"obstacles = {obstacles}: only {len(shapes)} fit with {spacing:g} m between centres; ask for fewer or less spacing"
        )
    low, high = np.array((0.0, 0.0, -SIDE_M)), np.array((SIDE_M, SIDE_M, 0.0))
    return Scene(f"{way}-{obstacles}-seed-{seed}", tuple(shapes), low, high, start, goal)


def _shape(centre: Array, generator: np.random.Generator) -> tuple[Shape, float]:
    """A cylinder or a box on the ground, one as likely as the other, and the radius around its centre that holds it."""
    north, east = float(centre[0]), float(centre[1])
    top = -(10.0 + 50.0 * generator.random())
    if generator.random() < 0.5:
        radius = float(generator.uniform(3.0, 7.0))
        return Cylinder(north, east, radius, top, 0.0), radius
    length, width = (float(side) for side in generator.uniform(6.0, 14.0, 2))
    heading = float(generator.uniform(0.0, 2.0 * math.pi))
    return OrientedBox(north, east, length, width, top, 0.0, heading), 0.5 * math.hypot(length, width)
