"""The bodies that a person states, and the rows that they become.

Positions are (north, east) in m, heights are `down` of top and bottom; headings are radians clockwise from north.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.space.bodies import BODY_COLUMNS, BOX, CYLINDER, SPHERE, SUPERQUADRIC

EXPONENT_MIN, EXPONENT_MAX = 0.1, 1.9
STANDSTILL = (0.0, 0.0, 0.0)

Velocity = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sphere:
    north_m: float
    east_m: float
    down_m: float
    radius_m: float
    velocity_ned_m_s: Velocity = STANDSTILL

    def row(self) -> tuple[float, ...]:
        _check_size("radius_m", self.radius_m)
        extent = (self.down_m - self.radius_m, self.down_m + self.radius_m)
        return (SPHERE, self.north_m, self.east_m, self.radius_m, 0.0, *extent, 1.0, 0.0, *self.velocity_ned_m_s)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A vertical cylinder with flat ends; endless upwards or downwards with infinite heights."""

    north_m: float
    east_m: float
    radius_m: float
    top_down_m: float = -math.inf
    bottom_down_m: float = math.inf
    velocity_ned_m_s: Velocity = STANDSTILL

    def row(self) -> tuple[float, ...]:
        _check_size("radius_m", self.radius_m)
        extent = _extent(self.top_down_m, self.bottom_down_m)
        return (CYLINDER, self.north_m, self.east_m, self.radius_m, 0.0, *extent, 1.0, 0.0, *self.velocity_ned_m_s)


@dataclass(frozen=True, slots=True)
class SuperquadricCylinder:
    """|x/r|^(2/e) + |y/r|^(2/e) <= 1 between two heights: e = 1 is a cylinder, towards 0 a square one, above 1 a rhombus."""

    north_m: float
    east_m: float
    radius_m: float
    exponent: float
    top_down_m: float = -math.inf
    bottom_down_m: float = math.inf
    heading_rad: float = 0.0
    velocity_ned_m_s: Velocity = STANDSTILL

    def row(self) -> tuple[float, ...]:
        _check_size("radius_m", self.radius_m)
        if not EXPONENT_MIN <= self.exponent <= EXPONENT_MAX:
            raise ValueError(f"exponent = {self.exponent}: must lie between {EXPONENT_MIN} and {EXPONENT_MAX}")
        extent = _extent(self.top_down_m, self.bottom_down_m)
        turn = (math.cos(self.heading_rad), math.sin(self.heading_rad))
        kind = CYLINDER if self.exponent == 1.0 else SUPERQUADRIC
        return (kind, self.north_m, self.east_m, self.radius_m, self.exponent, *extent, *turn, *self.velocity_ned_m_s)


@dataclass(frozen=True, slots=True)
class OrientedBox:
    """An upright box; `length_m` lies along `heading_rad`, `width_m` across."""

    north_m: float
    east_m: float
    length_m: float
    width_m: float
    top_down_m: float = -math.inf
    bottom_down_m: float = math.inf
    heading_rad: float = 0.0
    velocity_ned_m_s: Velocity = STANDSTILL

    def row(self) -> tuple[float, ...]:
        _check_size("length_m", self.length_m)
        _check_size("width_m", self.width_m)
        extent = _extent(self.top_down_m, self.bottom_down_m)
        turn = (math.cos(self.heading_rad), math.sin(self.heading_rad))
        half = (0.5 * self.length_m, 0.5 * self.width_m)
        return (BOX, self.north_m, self.east_m, *half, *extent, *turn, *self.velocity_ned_m_s)


Shape = Sphere | Cylinder | SuperquadricCylinder | OrientedBox


def bodies_of(shapes: Iterable[Shape]) -> Array:
    """Rows (n, BODY_COLUMNS) of `shapes`; ValueError on a size that is no size or a position that is not finite."""
    rows = np.array([shape.row() for shape in shapes], dtype=np.float64).reshape(-1, BODY_COLUMNS)
    finite = np.isfinite(rows).all(axis=1) | (
        np.isfinite(np.delete(rows, (5, 6), axis=1)).all(axis=1) & ~np.isnan(rows).any(axis=1)
    )
    if not finite.all():
        raise ValueError(f"body {int(np.flatnonzero(~finite)[0])}: position, size and velocity must be finite numbers")
    return rows


def no_bodies() -> Array:
    """The rows (0, BODY_COLUMNS) of nothing."""
    return np.zeros((0, BODY_COLUMNS))


def bodies_of_discs(discs: Array) -> Array:
    """Rows (n, BODY_COLUMNS) of the `discs` (n, 7) of an ObstacleSet: vertical cylinders, moving as observed."""
    rows = np.zeros((len(discs), BODY_COLUMNS))
    rows[:, 0] = CYLINDER
    rows[:, 1:4] = discs[:, :3]
    rows[:, 5:7] = discs[:, 5:7]
    rows[:, 7] = 1.0
    rows[:, 9:11] = discs[:, 3:5]
    return rows


def _check_size(field: str, value: float) -> None:
    if not (value >= 0.0 and math.isfinite(value)):
        raise ValueError(f"{field} = {value}: must be a finite number, zero or greater")


def _extent(top: float, bottom: float) -> tuple[float, float]:
    if not top <= bottom:
        raise ValueError(f"top_down_m = {top}: must not lie below bottom_down_m = {bottom}; down is positive")
    return top, bottom
