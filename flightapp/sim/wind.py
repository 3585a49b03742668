"""Air that moves by a sum of harmonics with a gust step, stronger with height: one model for every simulator.

w(t, z) = (sum_k A_k sin(omega_k t + phi_k) + Delta H(t - t0)) (1 + lambda z / z_ref) for each axis. Source: Yan, Liu, Hao, Drones
9(9):611, 2025, which gives no figures; the defaults are specification 2.1's. It comes on top of the simulators' own mean wind
and random gusts. Every vehicle of a scene flies in the same air: the phases are the seed's, not the vehicle's.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import numba
import numpy as np

from flightapp.config.wind import HarmonicWind, Triple
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

AXES = 3
HEADER = 6
"""Of the flat array: step north, east, down, its time, lambda / z_ref, number of harmonics."""
STILL = np.zeros(0)
"""No such wind at all."""


def drawn(wind: HarmonicWind, key: int) -> Array:
    """The flat array that `air_velocity` reads, with the phases that `key` stands for."""
    count = len(wind.frequencies_rad_s)
    header = (*wind.step_ned_m_s, wind.step_at_s, wind.height_gain / wind.height_reference_m, float(count))
    amplitudes = (wind.amplitudes_horizontal_m_s, wind.amplitudes_horizontal_m_s, wind.amplitudes_vertical_m_s)
    phases = random.Random(f"air {key}")
    waves = [
        (frequency, amplitudes[axis][wave], phases.uniform(0.0, 2.0 * math.pi))
        for axis in range(AXES)
        for wave, frequency in enumerate(wind.frequencies_rad_s)
    ]
    return np.array([*header, *(value for wave in waves for value in wave)], dtype=np.float64)


@compiled(numba.float64(numba.float64[::1], numba.float64))
def height_factor(wind: Array, height_m: float) -> float:
    """How much faster the air moves at `height_m` above the ground than on it."""
    factor: float = 1.0 + wind[4] * max(0.0, height_m)
    return factor


@compiled(numba.float64(numba.float64[::1], numba.int64, numba.float64, numba.float64))
def air_velocity(wind: Array, axis: int, t_s: float, height_m: float) -> float:
    """Velocity of the air along north (0), east (1) or down (2) at `t_s` and `height_m` above the ground, m/s."""
    count = int(wind[5])
    moved = wind[axis] if t_s >= wind[3] else 0.0
    for wave in range(count):
        at = HEADER + 3 * (axis * count + wave)
        moved += wind[at + 1] * math.sin(wind[at] * t_s + wind[at + 2])
    velocity: float = moved * height_factor(wind, height_m)
    return velocity


@compiled(numba.float64(numba.float64[::1], numba.float64))
def air_speed_max(wind: Array, height_m: float) -> float:
    """No more than this moves the air in the plane up to `height_m`, m/s."""
    if len(wind) == 0:
        return 0.0
    count = int(wind[5])
    squared = 0.0
    for axis in range(2):
        size = abs(wind[axis])
        for wave in range(count):
            size += abs(wind[HEADER + 3 * (axis * count + wave) + 1])
        squared += size * size
    speed: float = math.sqrt(squared) * height_factor(wind, height_m)
    return speed


def air(wind: HarmonicWind, key: int) -> Callable[[float, float], Triple]:
    """Velocity of the air, NED in m/s, at a time and a height above the ground."""
    waves = drawn(wind, key)
    return lambda t_s, height_m: (
        air_velocity(waves, 0, t_s, height_m),
        air_velocity(waves, 1, t_s, height_m),
        air_velocity(waves, 2, t_s, height_m),
    )
