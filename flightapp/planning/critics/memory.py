"""Memory: how much a candidate revisits where the vehicle has just been."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled


@compiled("f8(f8)")
def _exp(x: float) -> float:
    """exp(x) for -4.5 <= x <= 0 within 1e-10, in arithmetic that runs over several points at a time: exp(x / 32) ** 32."""
    y = x * 0.03125
    power = 1.0 + y * (1.0 + y * (1 / 2 + y * (1 / 6 + y * (1 / 24 + y * (1 / 120 + y * (1 / 720 + y * (1 / 5040)))))))
    power *= power
    power *= power
    power *= power
    power *= power
    return power * power


@compiled("void(f8[:,:,::1],i8,f8[:,::1],f8,i8[::1],f8[::1])")
def _memory(paths: Array, steps: int, history: Array, scale_m: float, which: NDArray[np.intp], out: Array) -> None:
    reach2 = 9.0 * scale_m * scale_m
    factor = -0.5 / (scale_m * scale_m)
    north = history[:, 0].copy()
    east = history[:, 1].copy()
    sums = np.empty(history.shape[0])
    for c in which:
        sums[:] = 0.0
        for k in range(steps):
            n = paths[c, k, 0]
            e = paths[c, k, 1]
            for h in range(sums.shape[0]):
                dn = n - north[h]
                de = e - east[h]
                distance2 = dn * dn + de * de
                penalty = _exp(factor * min(distance2, reach2))
                sums[h] += penalty if distance2 < reach2 else 0.0
        out[c] = sums.sum()


def memory(paths: Array, steps: int, history: Array, scale_m: float, which: NDArray[np.intp], out: Array) -> None:
    """Fill out (n,): sum of exp(-d^2 / (2 scale^2)) over the first `steps` points of each path and the history; a penalty.

    paths (n, >=steps, 2) and history (h, 2) in m, for the candidates `which`; the kernel is cut off at three scales.
    """
    _memory(paths, steps, history, scale_m, which, out)


@compiled("void(f8[::1],f8[::1],f8,f8,f8,f8,f8[::1])")
def _revisit(north: Array, east: Array, past_n: float, past_e: float, factor: float, reach2: float, out: Array) -> None:
    """Add the penalty of one past position to all candidates."""
    for c in range(out.shape[0]):
        dn = north[c] - past_n
        de = east[c] - past_e
        distance2 = dn * dn + de * de
        within = distance2 if distance2 < reach2 else reach2
        penalty = _exp(factor * within)
        out[c] += penalty if distance2 < reach2 else 0.0


@compiled("void(f8[:,::1],f8[:,::1],f8[:,::1],f8,f8[::1])")
def memory_score(north: Array, east: Array, history: Array, scale_m: float, out: Array) -> None:
    """Fill out (n,): sum of exp(-d^2 / (2 scale^2)) over the points of each path and the history; a penalty.

    north, east (points, n) and history (h, 2) in m; the kernel is cut off at three scales.
    """
    reach2 = 9.0 * scale_m * scale_m
    factor = -0.5 / (scale_m * scale_m)
    for c in range(out.shape[0]):
        out[c] = 0.0
    for k in range(north.shape[0]):
        for h in range(history.shape[0]):
            _revisit(north[k], east[k], history[h, 0], history[h, 1], factor, reach2, out)
