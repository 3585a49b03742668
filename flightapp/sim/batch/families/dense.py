"""Family `dense` (A2): random discs, the evader runs to the line north = 0, pursuers come from behind and the sides."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from flightapp.core.errors import InputError
from flightapp.core.types import Array, Boundary
from flightapp.sim.batch.families.field import scattered
from flightapp.sim.batch.families.layout import (
    Area,
    FamilyLayout,
    Layout,
    Team,
    chasing_starts,
    disc_rows,
    standing_discs,
    start_rows,
)

ATTEMPTS_MAX = 20_000


class DenseLayout(FamilyLayout):
    """Places in m from the corner of the rectangle; the protected line is its edge north = 0."""

    north_m: float = Field(default=75.0, gt=0)
    east_m: float = Field(default=50.0, gt=0)
    discs: int = Field(default=20, ge=0, le=2000)
    disc_radius_min_m: float = Field(default=0.4, gt=0)
    disc_radius_max_m: float = Field(default=1.5, gt=0)
    disc_gap_m: float = Field(default=2.0, ge=0)
    """Smallest distance between the surfaces of two discs: a vehicle passes between any two."""
    disc_north_min_m: float = 4.0
    disc_north_max_m: float = 70.0
    moving_discs: int = Field(default=0, ge=0)
    """So many of the discs move, in a random direction."""
    moving_speed_m_s: float = Field(default=1.0, ge=0)
    evader_start_m: tuple[float, float] = (58.0, 25.0)
    pursuer_starts_m: tuple[tuple[float, float], ...] = ((74.0, 2.0), (74.0, 48.0))
    start_noise_m: float = Field(default=1.0, ge=0)
    """Each start is shaken by up to this, each axis."""
    heading_noise_deg: float = Field(default=45.0, ge=0, le=180)
    """Evader: about the way to the line; pursuers: about the way to the evader."""
    start_clear_m: float = Field(default=1.5, ge=0)
    """Between a start and the surface of a disc."""

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        evader, pursuers = chasing_starts(
            team, self.evader_start_m, self.pursuer_starts_m, self.start_noise_m, self.heading_noise_deg, random
        )
        discs = self._field(start_rows([evader, *pursuers]), random)
        boundary = Boundary(np.array([[0.0, 0.0], [0.0, self.east_m]]), False)
        return Layout(disc_rows(discs), boundary, pursuers, evader, Area(0.0, self.north_m, 0.0, self.east_m))

    def _field(self, starts: Array, random: np.random.Generator) -> list[list[float]]:
        low = (self.disc_north_min_m, self.disc_radius_max_m, self.disc_radius_min_m)
        high = (self.disc_north_max_m, self.east_m - self.disc_radius_max_m, self.disc_radius_max_m)
        field = scattered(low, high, self.discs, ATTEMPTS_MAX, starts, self.start_clear_m, self.disc_gap_m, random)
        if len(field) < self.discs:
            raise InputError(
                f"layout.discs = {self.discs}: only {len(field)} found room; fewer, smaller discs or a smaller disc_gap_m"
            )
        discs = standing_discs(field)
        for row, direction in zip(discs[: self.moving_discs], random.uniform(-math.pi, math.pi, self.moving_discs), strict=False):
            row[3] = self.moving_speed_m_s * math.cos(direction)
            row[4] = self.moving_speed_m_s * math.sin(direction)
        return discs
