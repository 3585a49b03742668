"""One concrete episode: where everything is and starts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.config.loading import Strict
from flightapp.core.types import Array, Boundary


@dataclass(frozen=True, slots=True)
class Start:
    """Where a vehicle stands at first: m, heading clockwise from north in rad."""

    north_m: float
    east_m: float
    heading_rad: float


@dataclass(frozen=True, slots=True)
class Area:
    """The rectangle of the scenario; moving obstacles turn round at its edges."""

    north_min_m: float
    north_max_m: float
    east_min_m: float
    east_max_m: float


@dataclass(frozen=True, slots=True)
class Team:
    """What a layout must know of the pursuers: how many, and what their centres keep from an obstacle's surface."""

    count: int
    inflation_m: float


@dataclass(frozen=True, slots=True)
class Layout:
    """What a seed makes of a scenario. discs: (n, 7) as in ObstacleSet, at t = 0."""

    discs: Array
    boundary: Boundary
    pursuers: tuple[Start, ...]
    evader: Start
    area: Area
    shortest_path_m: float | None = None
    """Of the first pursuer to the evader's start, around the discs."""


class FamilyLayout(Strict):
    """Base of the layout tables: the parameters from which a family draws one layout a seed."""

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        """One layout; InputError where the parameters leave no room for it."""
        raise NotImplementedError


def disc(north_m: float, east_m: float, radius_m: float, v_north_m_s: float = 0.0, v_east_m_s: float = 0.0) -> list[float]:
    """One row of `Layout.discs`, of unknown height."""
    return [north_m, east_m, radius_m, v_north_m_s, v_east_m_s, -math.inf, math.inf]


def disc_rows(discs: list[list[float]]) -> Array:
    """(n, 7), also for none."""
    return np.array(discs, dtype=np.float64).reshape(-1, 7)


def is_clear(north_m: float, east_m: float, discs: list[list[float]], distance_m: float) -> bool:
    """Whether a point is at least `distance_m` from every disc's surface."""
    return all(math.hypot(north_m - row[0], east_m - row[1]) >= row[2] + distance_m for row in discs)
