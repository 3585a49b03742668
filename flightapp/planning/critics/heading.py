"""Heading: how well the end of a candidate points at the aim."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled


@compiled("void(f8[:,::1],f8,f8,i8[::1],f8[::1])")
def _heading(ends: Array, aim_n: float, aim_e: float, which: NDArray[np.intp], out: Array) -> None:
    for c in which:
        sight = math.atan2(aim_e - ends[c, 1], aim_n - ends[c, 0])
        turn = abs(ends[c, 2] - sight) % (2.0 * math.pi)
        out[c] = math.pi - min(turn, 2.0 * math.pi - turn)


def heading(ends: Array, aim: tuple[float, float], which: NDArray[np.intp], out: Array) -> None:
    """Fill out (n,): pi - |angle between end heading and the line of sight to `aim`| (rad), for the candidates `which`.

    ends: (n, 3) north, east, heading.
    """
    _heading(ends, aim[0], aim[1], which, out)
