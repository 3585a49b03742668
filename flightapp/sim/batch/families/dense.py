"""Family `dense` (A2): random discs, the evader runs to the line north = 0, pursuers come from behind and the sides."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from flightapp.core.angles import wrap_pi
from flightapp.core.errors import InputError
from flightapp.core.types import Boundary
from flightapp.sim.batch.families.layout import Area, FamilyLayout, Layout, Start, Team, disc, disc_rows, is_clear

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
    evader_start_m: tuple[float, float] = (60.0, 25.0)
    pursuer_starts_m: tuple[tuple[float, float], ...] = ((74.0, 2.0), (74.0, 48.0))
    start_noise_m: float = Field(default=1.0, ge=0)
    """Each start is shaken by up to this, each axis."""
    heading_noise_deg: float = Field(default=45.0, ge=0, le=180)
    """Evader: about the way to the line; pursuers: about the way to the evader."""
    start_clear_m: float = Field(default=1.5, ge=0)
    """Between a start and the surface of a disc."""

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        if team.count > len(self.pursuer_starts_m):
            raise InputError(
                f"layout.pursuer_starts_m: {len(self.pursuer_starts_m)} starts for pursuers.count = {team.count}; give one each"
            )
        evader = self._start(self.evader_start_m, math.pi, random)
        pursuers = [
            self._start(place, math.atan2(evader.east_m - place[1], evader.north_m - place[0]), random)
            for place in self.pursuer_starts_m[: team.count]
        ]
        discs = self._field([evader, *pursuers], random)
        boundary = Boundary(np.array([[0.0, 0.0], [0.0, self.east_m]]), False)
        return Layout(disc_rows(discs), boundary, tuple(pursuers), evader, Area(0.0, self.north_m, 0.0, self.east_m))

    def _start(self, place: tuple[float, float], heading_rad: float, random: np.random.Generator) -> Start:
        north, east = random.uniform(-self.start_noise_m, self.start_noise_m, 2)
        noise = math.radians(self.heading_noise_deg)
        return Start(place[0] + float(north), place[1] + float(east), wrap_pi(heading_rad + float(random.uniform(-noise, noise))))

    def _field(self, starts: list[Start], random: np.random.Generator) -> list[list[float]]:
        discs: list[list[float]] = []
        low = np.array((self.disc_north_min_m, self.disc_radius_max_m, self.disc_radius_min_m, -math.pi))
        high = np.array((self.disc_north_max_m, self.east_m - self.disc_radius_max_m, self.disc_radius_max_m, math.pi))
        for _ in range(ATTEMPTS_MAX):
            if len(discs) == self.discs:
                break
            north, east, radius, direction = random.uniform(low, high).tolist()
            speed = self.moving_speed_m_s if len(discs) < self.moving_discs else 0.0
            far = all(math.hypot(north - s.north_m, east - s.east_m) >= radius + self.start_clear_m for s in starts)
            if far and is_clear(north, east, discs, radius + self.disc_gap_m):
                discs.append(disc(north, east, radius, speed * math.cos(direction), speed * math.sin(direction)))
        if len(discs) < self.discs:
            raise InputError(
                f"layout.discs = {self.discs}: only {len(discs)} found room; fewer, smaller discs or a smaller disc_gap_m"
            )
        return discs
