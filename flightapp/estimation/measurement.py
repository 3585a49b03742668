"""One measurement of the evader: what it told of itself, or what somebody's camera saw of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from flightapp.core.types import Array

MAGNITUDE_MAX = 1e7
TIME_MAX_S = 1e11
SIGMA_MIN, SIGMA_MAX = 1e-3, 1e4
ROWS_MAX = 6
ROW_LENGTH = 8

Row = tuple[float, float, float, float, float, float, float, float]


class Measurement(NamedTuple):
    """Independent scalars, each a row: direction in (position, velocity) NED (6 numbers), value, variance.

    is_named: it is known to be of the evader, because the evader said it. A camera sees something where the evader should be, so
    its sightings correct a track but never start one.
    """

    t_s: float
    is_named: bool
    rows: tuple[Row, ...]


def told(
    t_s: float,
    position_ned_m: Array | Sequence[float],
    velocity_ned_m_s: Array | Sequence[float] | None,
    position_sigma_m: float,
    velocity_sigma_m_s: float,
) -> Measurement | None:
    """What the evader told: position (3,), velocity (3,) or None, standard deviations per axis; None where a number is unusable.

    Unusable: not finite or absurd (the velocity's numbers only where there is one), or a deviation that is not positive.
    """
    values, sigmas = _numbers(position_ned_m), [position_sigma_m] * 3
    if velocity_ned_m_s is not None:
        values, sigmas = values + _numbers(velocity_ned_m_s), sigmas + [velocity_sigma_m_s] * 3
    if not _are_usable(t_s, values, sigmas):
        return None
    rows = tuple(
        _row([float(axis == of) for of in range(6)], value, sigma)
        for axis, (value, sigma) in enumerate(zip(values, sigmas, strict=True))
    )
    return Measurement(float(t_s), True, rows)


def seen(
    t_s: float, north_m: float, east_m: float, bearing_rad: float, range_sigma_m: float, across_sigma_m: float
) -> Measurement | None:
    """What a camera saw in the plane; None where a number is unusable.

    bearing_rad: of the line of sight, clockwise from north; the deviations are along and across it. Height is not measured.
    """
    if not _are_usable(t_s, [north_m, east_m, bearing_rad], [range_sigma_m, across_sigma_m]):
        return None
    cos, sin = math.cos(bearing_rad), math.sin(bearing_rad)
    rows = (
        _row([cos, sin, 0.0, 0.0, 0.0, 0.0], north_m * cos + east_m * sin, range_sigma_m),
        _row([-sin, cos, 0.0, 0.0, 0.0, 0.0], east_m * cos - north_m * sin, across_sigma_m),
    )
    return Measurement(float(t_s), False, rows)


def _numbers(vector: Array | Sequence[float]) -> list[float]:
    return [float(number) for number in np.asarray(vector, dtype=np.float64).tolist()]


def _are_usable(t_s: float, values: Sequence[float], sigmas: Sequence[float]) -> bool:
    return (
        abs(t_s) < TIME_MAX_S
        and all(abs(value) < MAGNITUDE_MAX for value in values)
        and all(0.0 < sigma < math.inf for sigma in sigmas)
    )


def _row(direction: Sequence[float], value: float, sigma: float) -> Row:
    north, east, down, v_north, v_east, v_down = direction
    return north, east, down, v_north, v_east, v_down, value, min(max(sigma, SIGMA_MIN), SIGMA_MAX) ** 2
