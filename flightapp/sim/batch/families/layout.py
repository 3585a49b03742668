"""One concrete episode: where everything is and starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.config.loading import Strict
from flightapp.core.angles import wrap_pi
from flightapp.core.errors import InputError
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
    polygons: tuple[Array, ...] = ()
    """Convex ones that stand in the way, (k, 2) north, east each."""


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


def start_rows(starts: Sequence[Start]) -> Array:
    """(n, 2) north, east."""
    return np.array([(start.north_m, start.east_m) for start in starts], dtype=np.float64).reshape(-1, 2)


def standing_discs(field: Array) -> list[list[float]]:
    """Rows of `Layout.discs` from (n, 3) north, east, radius."""
    return [disc(north, east, radius) for north, east, radius in field.tolist()]


def shaken(
    place: tuple[float, float], heading_rad: float, noise_m: float, heading_noise_deg: float, random: np.random.Generator
) -> Start:
    """A start about `place`: within `noise_m` on each axis and `heading_noise_deg` of `heading_rad`."""
    north, east, turn = random.uniform(-1.0, 1.0, 3).tolist()
    heading = wrap_pi(heading_rad + turn * math.radians(heading_noise_deg))
    return Start(place[0] + north * noise_m, place[1] + east * noise_m, heading)


def chasing_starts(
    team: Team,
    evader_m: tuple[float, float],
    pursuers_m: Sequence[tuple[float, float]],
    noise_m: float,
    heading_noise_deg: float,
    random: np.random.Generator,
) -> tuple[Start, tuple[Start, ...]]:
    """The evader, heading south, and `team.count` pursuers, heading for it, each shaken about its place in m."""
    if team.count > len(pursuers_m):
        raise InputError(f"layout.pursuer_starts_m: {len(pursuers_m)} starts for pursuers.count = {team.count}; give one each")
    evader = shaken(evader_m, math.pi, noise_m, heading_noise_deg, random)
    pursuers = []
    for place in pursuers_m[: team.count]:
        towards_rad = math.atan2(evader.east_m - place[1], evader.north_m - place[0])
        pursuers.append(shaken(place, towards_rad, noise_m, heading_noise_deg, random))
    return evader, tuple(pursuers)
