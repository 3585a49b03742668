"""Angles in radians, clockwise from north."""

from __future__ import annotations

import math

TWO_PI = 2.0 * math.pi


def wrap_pi(angle_rad: float) -> float:
    """`angle_rad` in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, TWO_PI)
    return math.pi if wrapped == -math.pi else wrapped


def bearing_rad(north_m: float, east_m: float) -> float:
    """Bearing of the planar vector (north, east), in (-pi, pi]."""
    return wrap_pi(math.atan2(east_m, north_m))
