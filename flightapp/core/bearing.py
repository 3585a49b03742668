"""Bearings in compiled code, where `math.remainder` is not known."""

from __future__ import annotations

import math

from flightapp.core.angles import TWO_PI
from flightapp.core.compiled import compiled


@compiled("f8(f8)")
def wrapped_rad(angle_rad: float) -> float:
    """`angle_rad` in (-pi, pi], bit for bit as `flightapp.core.angles.wrap_pi` for less than a turn and a half."""
    wrapped = angle_rad
    if abs(angle_rad) > 3.0 * math.pi:
        wrapped = angle_rad - TWO_PI * math.floor((angle_rad + math.pi) / TWO_PI)
    if wrapped > math.pi:
        wrapped -= TWO_PI
    elif wrapped <= -math.pi:
        wrapped += TWO_PI
    return wrapped
