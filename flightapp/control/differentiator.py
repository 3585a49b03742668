"""The tracking differentiator: a smooth value and its derivative from a raw reference; exact for a reference held in the step."""

from __future__ import annotations

import math

import numba

from flightapp.control.observer import VECTOR
from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled(numba.void(VECTOR, VECTOR, numba.float64, numba.float64, numba.float64))
def differentiate(state: Array, wanted: Array, bandwidth_rad_s: float, damping: float, dt_s: float) -> None:
    """state (2 n,): values, then derivatives, moved by `dt_s` towards `wanted` (n,). `damping` below 1.

    A ramp is followed late by 2 damping / bandwidth: 0.07 s with the source's 20 rad/s and 0.7. A reference that is not finite
    leaves the state as it is.
    """
    if not dt_s > 0.0:
        return
    n = len(wanted)
    decay = math.exp(-damping * bandwidth_rad_s * dt_s)
    swing = bandwidth_rad_s * math.sqrt(1.0 - damping * damping)
    cos, sin = math.cos(swing * dt_s), math.sin(swing * dt_s)
    lead = damping * bandwidth_rad_s / swing
    for k in range(n):
        if not math.isfinite(wanted[k]):
            continue
        off, rate = state[k] - wanted[k], state[n + k]
        state[k] = wanted[k] + decay * ((cos + lead * sin) * off + sin / swing * rate)
        state[n + k] = decay * ((cos - lead * sin) * rate - bandwidth_rad_s * bandwidth_rad_s / swing * sin * off)
