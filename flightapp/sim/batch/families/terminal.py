"""Family `terminal` (A3): the last metres: one pursuer behind a weaving evader, a few obstacles between them and the boundary."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from flightapp.core.angles import wrap_pi
from flightapp.core.errors import InputError
from flightapp.core.types import Boundary
from flightapp.sim.batch.families.field import scattered
from flightapp.sim.batch.families.layout import (
    Area,
    FamilyLayout,
    Layout,
    Start,
    Team,
    disc_rows,
    standing_discs,
    start_rows,
)

ATTEMPTS_MAX = 10_000


class TerminalLayout(FamilyLayout):
    """The evader starts in the north and runs to the line north = 0."""

    distance_m: float = Field(default=20.0, gt=0)
    """Of the pursuer from the evader at the start."""
    bearing_max_deg: float = Field(default=60.0, ge=0, le=180)
    """The pursuer stands at most so far off straight behind the evader."""
    boundary_m: float = Field(default=80.0, gt=0)
    """Of the evader's start from the protected line."""
    width_m: float = Field(default=60.0, gt=0)
    discs: int = Field(default=6, ge=0)
    disc_radius_min_m: float = Field(default=0.4, gt=0)
    disc_radius_max_m: float = Field(default=1.2, gt=0)
    disc_gap_m: float = Field(default=3.0, ge=0)
    heading_noise_deg: float = Field(default=45.0, ge=0, le=180)
    start_clear_m: float = Field(default=1.5, ge=0)

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        if team.count != 1:
            raise InputError(f"pursuers.count = {team.count}: the family 'terminal' has one pursuer")
        noise, aside = math.radians(self.heading_noise_deg), math.radians(self.bearing_max_deg)
        bearing = float(random.uniform(-aside, aside))
        turned = random.uniform(-noise, noise, 2)
        evader = Start(self.boundary_m, 0.0, wrap_pi(math.pi + float(turned[0])))
        north, east = self.boundary_m + self.distance_m * math.cos(bearing), self.distance_m * math.sin(bearing)
        pursuer = Start(north, east, wrap_pi(bearing + math.pi + float(turned[1])))
        half = self.width_m / 2.0
        discs = self._field((evader, pursuer), half, random)
        boundary = Boundary(np.array([[0.0, -half], [0.0, half]]), False)
        return Layout(disc_rows(discs), boundary, (pursuer,), evader, Area(0.0, self.boundary_m + self.distance_m, -half, half))

    def _field(self, starts: tuple[Start, ...], half: float, random: np.random.Generator) -> list[list[float]]:
        """Discs around the way that evader and pursuer take."""
        far = self.boundary_m + self.distance_m
        low, high = (0.3 * far, -half / 3.0, self.disc_radius_min_m), (far, half / 3.0, self.disc_radius_max_m)
        clear, gap = self.start_clear_m, self.disc_gap_m
        field = scattered(low, high, self.discs, ATTEMPTS_MAX, start_rows(starts), clear, gap, random)
        if len(field) < self.discs:
            raise InputError(
                f"layout.discs = {self.discs}: only {len(field)} found room; fewer, smaller discs or a smaller disc_gap_m"
            )
        return standing_discs(field)
