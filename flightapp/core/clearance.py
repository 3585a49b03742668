"""The one clearance function: planner, supervisor, metrics and tests all measure distance here.

Clearance is the distance from the surface of a body (disc of `body_radius_m`) to the surface of a disc; negative means
overlap. Everything is planar (north, east).
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array

NO_OBSTACLE_M = 1e9


def disc_clearances_m(point_m: Array, discs: Array, body_radius_m: float) -> Array:
    """Clearance (n,) of a body at `point_m` (2,) to each of `discs` (n, >=3: north, east, radius)."""
    offset = discs[:, :2] - point_m
    return np.hypot(offset[:, 0], offset[:, 1]) - discs[:, 2] - body_radius_m


def clearance_m(point_m: Array, discs: Array, body_radius_m: float) -> float:
    """Smallest clearance of a body at `point_m` (2,) to `discs` (n, >=3); NO_OBSTACLE_M without discs."""
    if len(discs) == 0:
        return NO_OBSTACLE_M
    return float(disc_clearances_m(point_m, discs, body_radius_m).min())


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


def segment_clearance_m(start_m: Array, end_m: Array, discs: Array, body_radius_m: float) -> float:
    """Smallest clearance of a body that moves along the segment `start_m` -> `end_m` (2,) to static `discs` (n, >=3)."""
    if len(discs) == 0:
        return NO_OBSTACLE_M
    along = end_m - start_m
    length2 = float(along @ along)
    offset = discs[:, :2] - start_m
    fraction = np.zeros(len(discs)) if length2 == 0.0 else np.clip(offset @ along / length2, 0.0, 1.0)
    gap = offset - fraction[:, None] * along
    return float((np.hypot(gap[:, 0], gap[:, 1]) - discs[:, 2]).min()) - body_radius_m
