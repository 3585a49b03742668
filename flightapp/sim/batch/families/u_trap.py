"""Family `u-trap` (A1): a U of small discs, closed towards the evader; the pursuer starts inside, near the closed end."""

from __future__ import annotations

import itertools
import math

import numpy as np
from pydantic import Field, model_validator

from flightapp.core.angles import wrap_pi
from flightapp.core.errors import InputError
from flightapp.core.types import Boundary
from flightapp.sim.batch.families.layout import Area, FamilyLayout, Layout, Start, Team, disc, disc_rows
from flightapp.sim.batch.shortest_path import shortest_path_m

ROOM_M = 60.0


class UTrapLayout(FamilyLayout):
    """The closed wall's inner surface is at north = 0, the opening to the south, the evader in the north."""

    depth_range_m: tuple[float, float] = (2.0, 20.0)
    """Inner depth, drawn from this range unless `depth_m` is given."""
    width_range_m: tuple[float, float] = (4.0, 16.0)
    """Inner width, surface to surface."""
    depth_m: float | None = Field(default=None, gt=0)
    width_m: float | None = Field(default=None, gt=0)
    disc_radius_m: float = Field(default=0.5, gt=0)
    disc_spacing_m: float = Field(default=0.8, gt=0)
    evader_range_m: tuple[float, float] = (12.0, 15.0)
    """Of the evader beyond the closed wall."""
    start_gap_m: tuple[float, float] = (0.3, 0.8)
    """Of the pursuer's start to the inflated closed wall."""
    heading_noise_deg: float = Field(default=45.0, ge=0, le=180)
    """About the way to the evader."""

    @model_validator(mode="after")
    def _is_closed(self) -> UTrapLayout:
        if self.disc_spacing_m >= 2.0 * self.disc_radius_m:
            raise ValueError(
                f"disc_spacing_m = {self.disc_spacing_m}: must be less than 2 disc_radius_m, so that the U is closed"
            )
        return self

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        if team.count != 1:
            raise InputError(f"pursuers.count = {team.count}: the family 'u-trap' has one pursuer")
        depth = self._drawn(self.depth_m, self.depth_range_m, random)
        width = self._drawn(self.width_m, self.width_range_m, random)
        beyond = float(random.uniform(*self.evader_range_m))
        gap = float(random.uniform(*self.start_gap_m))
        aside = float(random.uniform(-0.5, 0.5)) * max(0.0, width - 2.0 * team.inflation_m - 1.0)
        noise = math.radians(self.heading_noise_deg)
        turned = float(random.uniform(-noise, noise))
        if min(width, 2.0 * depth) < 2.0 * team.inflation_m + 0.2:
            raise InputError(
                f"layout.width_m = {width:g}, depth_m = {depth:g}: no room for a vehicle that keeps {team.inflation_m:g} m"
            )
        evader = Start(2.0 * self.disc_radius_m + beyond, 0.0, 0.0)
        north = -min(team.inflation_m + gap, depth)
        start = Start(north, aside, wrap_pi(math.atan2(-aside, evader.north_m - north) + turned))
        discs = disc_rows(self._wall(depth, width))
        way = shortest_path_m((start.north_m, start.east_m), (evader.north_m, evader.east_m), discs, team.inflation_m)
        side = width / 2.0 + ROOM_M
        area = Area(-depth - ROOM_M, evader.north_m + ROOM_M, -side, side)
        line = evader.north_m + ROOM_M / 2.0
        return Layout(discs, Boundary(np.array([[line, -side], [line, side]]), False), (start,), evader, area, way)

    @staticmethod
    def _drawn(fixed: float | None, limits: tuple[float, float], random: np.random.Generator) -> float:
        drawn = float(random.uniform(*limits))
        return drawn if fixed is None else fixed

    def _wall(self, depth: float, width: float) -> list[list[float]]:
        radius = self.disc_radius_m
        side = width / 2.0 + radius
        corners = [(-depth, -side), (radius, -side), (radius, side), (-depth, side)]
        rows = [disc(*corners[0], radius)]
        for (north, east), (to_north, to_east) in itertools.pairwise(corners):
            count = math.ceil(math.dist((north, east), (to_north, to_east)) / self.disc_spacing_m)
            step_n, step_e = (to_north - north) / count, (to_east - east) / count
            rows += [disc(north + step_n * k, east + step_e * k, radius) for k in range(1, count + 1)]
        return rows
