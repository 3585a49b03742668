"""Start or goal in collision: the nearest place that is free, within reason (specification, section 4)."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array
from flightapp.space.way import RESOLUTION_M
from flightapp.space.world import World

MOVED_MAX_M = 5.0
CLIMBS = 40
"""Steps along the gradient before places all around are tried."""
SHELLS = 10
WAY_OUT_STEP_M = 0.05
DIRECTIONS = 96


def put_right(world: World, place: Array, gap_m: float, low: Array, high: Array, *, is_flown: bool = False) -> Array | None:
    """`place` (3,) itself where it keeps `gap_m` from the bodies at rest, else a free place near it; None within 5 m of none.

    Out along the gradient of the signed distance; where two bodies push against each other, the first free place on shells
    around it. Always within the box from `low` to `high`. is_flown: the straight way there leads through no other body.
    """
    wanted = gap_m + RESOLUTION_M
    if world.resting_distance_m(place) >= wanted:
        return place
    here = place.copy()
    for _ in range(CLIMBS):
        distance, gradient = world.resting_distance_and_gradient(here)
        if distance >= wanted:
            break
        here = np.clip(here + (wanted + 0.01 - distance) * gradient, low, high)
    if math.dist(here, place) <= MOVED_MAX_M and _is_right(world, place, here, wanted, is_flown=is_flown):
        return here
    for radius in np.linspace(MOVED_MAX_M / SHELLS, MOVED_MAX_M, SHELLS):
        for direction in _directions():
            here = place + radius * direction
            if (here >= low).all() and (here <= high).all() and _is_right(world, place, here, wanted, is_flown=is_flown):
                return np.asarray(here)
    return None


def _is_right(world: World, place: Array, here: Array, wanted_m: float, *, is_flown: bool) -> bool:
    return world.resting_distance_m(here) >= wanted_m and (not is_flown or _leads_out(world, place, here))


def _leads_out(world: World, place: Array, free: Array) -> bool:
    """Whether the straight way from a place to a `free` one comes no deeper into a body, and into none once it is out."""
    begun = world.resting_distance_m(place)
    least = 0.5 * begun if begun > 0.0 else begun
    for share in np.linspace(0.0, 1.0, 1 + math.ceil(math.dist(place, free) / WAY_OUT_STEP_M)):
        distance = world.resting_distance_m(place + share * (free - place))
        if distance < least - RESOLUTION_M:
            return False
        least = max(least, min(distance, 0.0))
    return True


def _directions() -> Array:
    """Unit vectors (DIRECTIONS, 3), evenly around (Fibonacci's spiral)."""
    k = np.arange(DIRECTIONS) + 0.5
    height = 1.0 - 2.0 * k / DIRECTIONS
    turn = math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - height * height)
    return np.stack((flat * np.cos(turn), flat * np.sin(turn), height), axis=1)
