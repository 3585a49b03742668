"""Heading: how well the end of a candidate points at the aim."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled


@compiled("void(f8[:,::1],f8,f8,f8[::1])")
def _heading(ends: Array, aim_n: float, aim_e: float, out: Array) -> None:
    for c in range(ends.shape[0]):
        sight = math.atan2(aim_e - ends[c, 1], aim_n - ends[c, 0])
        turn = abs(ends[c, 2] - sight) % (2.0 * math.pi)
        out[c] = math.pi - min(turn, 2.0 * math.pi - turn)


def heading(ends: Array, aim: tuple[float, float]) -> Array:
    """pi - |angle between end heading and the line of sight to `aim`| (rad), (n,); ends (n, 3): north, east, heading."""
    out = np.empty(len(ends))
    _heading(ends, aim[0], aim[1], out)
    return out
