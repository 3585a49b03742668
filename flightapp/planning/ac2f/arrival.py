"""When a pursuer arrives, and how an early one shapes its speed so that all arrive together (timed synchronisation)."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.records import PARAMETERS_TYPE, Record


@compiled("f8(f8,f8,f8,f8,f8)")
def intercept_time_s(north: float, east: float, velocity_n: float, velocity_e: float, speed_m_s: float) -> float:
    """When a vehicle with `speed_m_s` meets a place that is (north, east) m away and moves with a velocity; NaN if never."""
    a = velocity_n * velocity_n + velocity_e * velocity_e - speed_m_s * speed_m_s
    b = north * velocity_n + east * velocity_e
    c = north * north + east * east
    if c == 0.0:
        return 0.0
    if abs(a) < 1e-9:
        return -c / (2.0 * b) if b < 0.0 else math.nan
    discriminant = b * b - a * c
    if discriminant < 0.0:
        return math.nan
    root = math.sqrt(discriminant)
    first = (-b - root) / a
    second = (-b + root) / a
    if first >= 0.0 and (first <= second or second < 0.0):
        return first
    return second if second >= 0.0 else math.nan


@compiled("f8(f8,f8,f8,f8,f8)")
def arrival_time_s(north: float, east: float, velocity_n: float, velocity_e: float, speed_m_s: float) -> float:
    """Estimated time until a place that moves is met, as `intercept_time_s`; straight to where it is if it never is."""
    time_s = intercept_time_s(north, east, velocity_n, velocity_e, speed_m_s)
    return math.hypot(north, east) / speed_m_s if math.isnan(time_s) else time_s


@compiled(numba.float64(PARAMETERS_TYPE, numba.float64, numba.types.Array(numba.float64, 1, "C")))
def speed_share(parameters: Record, eta_s: float, etas: Array) -> float:
    """Share of its speed with which a pursuer that would arrive in `eta_s` arrives no more than the window before the last.

    etas: (k,) s, of the others; NaN where unknown.
    """
    last = 0.0
    for i in range(etas.shape[0]):
        if etas[i] > last:
            last = etas[i]
    latest = last - parameters[0].arrival_window_s
    return 1.0 if latest <= eta_s else max(parameters[0].arrival_slowdown_min, eta_s / latest)
