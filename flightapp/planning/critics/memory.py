"""Memory: how much a candidate revisits where the vehicle has just been."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled


@compiled("void(f8[:,:,::1],i8,f8[:,::1],f8,i8[::1],f8[::1])")
def _memory(paths: Array, steps: int, history: Array, scale_m: float, which: NDArray[np.intp], out: Array) -> None:
    reach2 = 9.0 * scale_m * scale_m
    factor = -0.5 / (scale_m * scale_m)
    for c in which:
        total = 0.0
        for k in range(steps):
            for h in range(history.shape[0]):
                dn = paths[c, k, 0] - history[h, 0]
                de = paths[c, k, 1] - history[h, 1]
                distance2 = dn * dn + de * de
                if distance2 < reach2:
                    total += math.exp(factor * distance2)
        out[c] = total


def memory(paths: Array, steps: int, history: Array, scale_m: float, which: NDArray[np.intp], out: Array) -> None:
    """Fill out (n,): sum of exp(-d^2 / (2 scale^2)) over the first `steps` points of each path and the history; a penalty.

    paths (n, >=steps, 2) and history (h, 2) in m, for the candidates `which`; the kernel is cut off at three scales.
    """
    _memory(paths, steps, history, scale_m, which, out)
