"""Family `suburban` (A5): blocks of houses between streets, trees along them; houses are rows of discs."""

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
    disc,
    disc_rows,
    standing_discs,
    start_rows,
)

ATTEMPTS_MAX = 1024


class SuburbanLayout(FamilyLayout):
    """Lots on a grid, a house on most of them; the protected line is the edge north = 0."""

    north_m: float = Field(default=330.0, gt=0)
    east_m: float = Field(default=189.0, gt=0)
    lot_m: float = Field(default=27.0, gt=0)
    """Side of a lot, with its share of the streets."""
    street_m: float = Field(default=10.0, gt=0)
    """Between the lots: free of houses."""
    built_share: float = Field(default=0.7, ge=0, le=1)
    """Of the lots that have a house."""
    house_min_m: float = Field(default=8.0, gt=0)
    disc_radius_m: float = Field(default=2.5, gt=0)
    """Of the discs that make a house."""
    trees: int = Field(default=80, ge=0)
    tree_radius_min_m: float = Field(default=0.4, gt=0)
    tree_radius_max_m: float = Field(default=1.8, gt=0)
    tree_gap_m: float = Field(default=2.5, ge=0)
    evader_start_m: tuple[float, float] = (250.0, 94.5)
    pursuer_starts_m: tuple[tuple[float, float], ...] = ((324.0, 10.0), (324.0, 179.0))
    start_noise_m: float = Field(default=5.0, ge=0)
    heading_noise_deg: float = Field(default=45.0, ge=0, le=180)
    start_clear_m: float = Field(default=2.0, ge=0)

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        evader, pursuers = chasing_starts(
            team, self.evader_start_m, self.pursuer_starts_m, self.start_noise_m, self.heading_noise_deg, random
        )
        starts = start_rows([evader, *pursuers])
        discs = self._houses(starts, random)
        discs += self._trees(starts, discs, random)
        boundary = Boundary(np.array([[0.0, 0.0], [0.0, self.east_m]]), False)
        return Layout(disc_rows(discs), boundary, pursuers, evader, Area(0.0, self.north_m, 0.0, self.east_m))

    def _houses(self, starts: Array, random: np.random.Generator) -> list[list[float]]:
        rows: list[list[float]] = []
        room = self.lot_m - self.street_m
        if room < self.house_min_m:
            raise InputError(f"layout.house_min_m = {self.house_min_m}: a lot leaves {room:g} m; a smaller house or street_m")
        for i in range(int(self.north_m / self.lot_m)):
            for j in range(int(self.east_m / self.lot_m)):
                built = float(random.uniform()) < self.built_share
                long, wide = (float(side) for side in random.uniform(self.house_min_m, room, 2))
                slack = random.uniform(-0.5, 0.5, 2)
                north = (i + 0.5) * self.lot_m + float(slack[0]) * (room - long)
                east = (j + 0.5) * self.lot_m + float(slack[1]) * (room - wide)
                house = self._house(north, east, long, wide)
                north_gap = np.abs(starts[:, 0] - north) - 0.5 * long
                east_gap = np.abs(starts[:, 1] - east) - 0.5 * wide
                if built and (np.maximum(north_gap, east_gap) >= self.start_clear_m).all():
                    rows += house
        return rows

    def _house(self, north: float, east: float, long: float, wide: float) -> list[list[float]]:
        """Discs along the inside of the walls, and inside as far as a gap would be left there."""
        radius = self.disc_radius_m
        along, across = (max(2, math.ceil((side - 2.0 * radius) / (1.2 * radius)) + 1) for side in (long, wide))
        return [
            disc(
                north + (a / (along - 1) - 0.5) * (long - 2.0 * radius),
                east + (b / (across - 1) - 0.5) * (wide - 2.0 * radius),
                radius,
            )
            for a in range(along)
            for b in range(across)
            if a in (0, along - 1) or b in (0, across - 1)
        ]

    def _trees(self, starts: Array, houses: list[list[float]], random: np.random.Generator) -> list[list[float]]:
        """Where a tree finds no room there is none."""
        low = (5.0, 2.0, self.tree_radius_min_m)
        high = (self.north_m - 5.0, self.east_m - 2.0, self.tree_radius_max_m)
        standing = disc_rows(houses)[:, :3]
        clear, gap = self.start_clear_m, self.tree_gap_m
        return standing_discs(scattered(low, high, self.trees, ATTEMPTS_MAX, starts, clear, gap, random, standing))
