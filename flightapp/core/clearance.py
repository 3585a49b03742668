"""The one clearance function: planner, supervisor, metrics and tests all measure distance here.

Clearance is the distance from the surface of a body (disc of `body_radius_m`) to the surface of a disc; negative means
overlap. Everything is planar (north, east), where it does not say that it is in space.

The compiled functions are for kernels, which inline them; those on arrays are the same in NumPy.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array

NO_OBSTACLE_M = 1e9


@compiled("f8(f8,f8,f8)")
def gap_m(north: float, east: float, reach_m: float) -> float:
    """Gap between two things whose centres are (north, east) m apart and whose radii together are `reach_m`."""
    return math.hypot(north, east) - reach_m


@compiled("f8(f8,f8,f8,f8)")
def nearest_share(north: float, east: float, along_n: float, along_e: float) -> float:
    """How much, in [0, 1], of the way that starts at (north, east) and goes by `along` leads to its nearest place to zero."""
    length2 = along_n * along_n + along_e * along_e
    if length2 == 0.0:
        return 0.0
    return min(1.0, max(0.0, -(north * along_n + east * along_e) / length2))


@compiled("f8(f8,f8,f8,f8,f8)")
def way_gap_m(north: float, east: float, along_n: float, along_e: float, reach_m: float) -> float:
    """Smallest gap, as `gap_m`, while the centres' offset goes straight from (north, east) by `along`: both may move."""
    share = nearest_share(north, east, along_n, along_e)
    return gap_m(north + share * along_n, east + share * along_e, reach_m)


def disc_clearances_m(point_m: Array, discs: Array, body_radius_m: float) -> Array:
    """Clearance (n,) of a body at `point_m` (2,) to each of `discs` (n, >=3: north, east, radius)."""
    offset = discs[:, :2] - point_m
    return np.hypot(offset[:, 0], offset[:, 1]) - discs[:, 2] - body_radius_m


def clearance_m(point_m: Array, discs: Array, body_radius_m: float) -> float:
    """Smallest clearance of a body at `point_m` (2,) to `discs` (n, >=3); NO_OBSTACLE_M without discs."""
    if len(discs) == 0:
        return NO_OBSTACLE_M
    return float(disc_clearances_m(point_m, discs, body_radius_m).min())


def clearance_in_space_m(point_ned_m: Array, discs: Array, body_radius_m: float) -> float:
    """Smallest clearance of a body at `point_ned_m` (3,) to `discs` (n, 7) with their heights; NO_OBSTACLE_M without discs.

    Beside a disc, and where its height is unknown, the planar one; above and below it the body is a ball.
    """
    if len(discs) == 0:
        return NO_OBSTACLE_M
    beside = np.hypot(discs[:, 0] - point_ned_m[0], discs[:, 1] - point_ned_m[1]) - discs[:, 2]
    past = np.maximum(discs[:, 5] - point_ned_m[2], point_ned_m[2] - discs[:, 6])
    gaps = np.where(past > 0.0, np.hypot(np.maximum(beside, 0.0), past), beside)
    return float((gaps - body_radius_m).min())


def closest_approach_m(start_m: Array, end_m: Array) -> tuple[float, float]:
    """Smallest distance of the segment of relative position `start_m` -> `end_m` (2,) or (3,) to zero, and where, in [0, 1]."""
    along = end_m - start_m
    length2 = float(along @ along)
    fraction = 0.0 if length2 == 0.0 else min(1.0, max(0.0, -float(start_m @ along) / length2))
    return float(np.linalg.norm(start_m + fraction * along)), fraction


def miss_m(offset_m: tuple[float, float], velocity_m_s: tuple[float, float]) -> float:
    """Predicted closest approach to a place at `offset_m` (north, east) that is neared at the relative `velocity_m_s`."""
    distance = math.hypot(*offset_m)
    closing = offset_m[0] * velocity_m_s[0] + offset_m[1] * velocity_m_s[1]
    if closing <= 0.0:
        return distance
    return abs(offset_m[0] * velocity_m_s[1] - offset_m[1] * velocity_m_s[0]) / math.hypot(*velocity_m_s)
