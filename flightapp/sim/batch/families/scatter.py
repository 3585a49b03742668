"""Family `scatter`: a team and an evader at given or drawn places among given and drawn obstacles, in an arena or before a goal.

The layouts of the encirclement paper (arXiv 2312.01326) and of the hunting paper (JMSE 13(2):221) are tables of it.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from pydantic import Field, model_validator

from flightapp.core.errors import InputError
from flightapp.core.types import Array, Boundary
from flightapp.planning.capture import widest_gap_rad
from flightapp.sim.batch.families.field import scattered
from flightapp.sim.batch.families.layout import (
    Area,
    FamilyLayout,
    Layout,
    Start,
    Team,
    disc,
    disc_rows,
    standing_discs,
    start_rows,
)
from flightapp.sim.batch.families.starts import ATTEMPTS_MAX, Box, Place, Starts, middle
from flightapp.sim.batch.walls import edge_rows, wall_distance_m

GOAL_SIDES = 24
AREA_MIN_M2 = 1e-6
CLUSTER_DISCS = 6


class ScatterLayout(FamilyLayout):
    """Places are north, east in m; boxes least north, least east, greatest north, greatest east."""

    arena_m: Box
    """Obstacles are drawn in it; where there is no goal, the evader that leaves it has escaped."""
    moves_in_m: Box | None = None
    """Moving obstacles turn round at its edges; the arena's where it is left out."""
    goal_m: Place | None = None
    """The evader within `goal_radius_m` of it has escaped; the arena's edge is open then."""
    goal_radius_m: float = Field(default=5.0, gt=0)
    pursuers: Starts
    evader: Starts
    evader_free: bool = False
    """Drawn again until the evader is not encircled at the start."""
    discs_m: tuple[tuple[float, float, float], ...] = ()
    """Given: north, east, radius."""
    moving_discs_m: tuple[tuple[float, float, float, float, float], ...] = ()
    """Given: north, east, radius, v_north, v_east in m/s."""
    chains_m: tuple[tuple[Place, ...], ...] = ()
    """Walls of discs of `chain_radius_m` that overlap, along the line through these places."""
    chain_radius_m: float = Field(default=1.0, gt=0)
    polygons_m: tuple[tuple[Place, ...], ...] = ()
    """Given convex polygons, corner by corner."""
    discs: int = Field(default=0, ge=0, le=2000)
    """Drawn."""
    disc_radius_min_m: float = Field(default=0.3, gt=0)
    disc_radius_max_m: float = Field(default=0.8, gt=0)
    disc_gap_m: float = Field(default=0.8, ge=0)
    """Smallest distance between the surfaces of two drawn obstacles, and between them and given discs."""
    polygons: int = Field(default=0, ge=0, le=2000)
    """So many of the drawn discs become polygons of four to seven corners on their rims."""
    clusters: int = Field(default=0, ge=0, le=100)
    """Drawn groups of discs that overlap, on circles of `cluster_radius`."""
    cluster_radius_min_m: float = Field(default=5.0, gt=0)
    cluster_radius_max_m: float = Field(default=12.5, gt=0)
    start_clear_m: float = Field(default=0.4, ge=0)
    """Between a start, or the goal, and the surface of a drawn obstacle."""

    @model_validator(mode="after")
    def _stands_free(self) -> ScatterLayout:
        if self.arena_m[0] >= self.arena_m[2] or self.arena_m[1] >= self.arena_m[3]:
            raise ValueError(f"arena_m = {list(self.arena_m)}: must be least north, least east, greatest north, greatest east")
        for number, corners in enumerate(self.polygons_m, 1):
            if not _is_convex(corners):
                raise ValueError(f"polygons_m: number {number} is not convex or has no area; cut it into convex parts")
        if self.polygons > self.discs:
            raise ValueError(f"polygons = {self.polygons}: so many of the drawn discs, which are discs = {self.discs}")
        return self

    def draw(self, team: Team, random: np.random.Generator) -> Layout:
        pursuers, evader = self._starts(team, random)
        given = [disc(*row) for row in self.discs_m] + [row for chain in self.chains_m for row in self._chain(chain)]
        given += self._clusters(start_rows([*pursuers, evader]), disc_rows(given), random)
        field = self._field(start_rows([*pursuers, evader]), disc_rows(given), random)
        polygons = [np.array(corners) for corners in self.polygons_m]
        polygons += [_inscribed(row, random) for row in field[: self.polygons]]
        moving = [disc(*row) for row in self.moving_discs_m]
        discs = disc_rows(moving + given + standing_discs(field[self.polygons :]))
        _check_starts((*pursuers, evader), discs, polygons, team.inflation_m)
        box = self.moves_in_m or self.arena_m
        return Layout(discs, self._boundary(), pursuers, evader, Area(*box[::2], *box[1::2]), polygons=tuple(polygons))

    def _starts(self, team: Team, random: np.random.Generator) -> tuple[tuple[Start, ...], Start]:
        for _ in range(ATTEMPTS_MAX):
            places = self.pursuers.places(team.count, "pursuers", (), random)
            (evader,) = self.evader.places(1, "evader", places, random)
            if not (self.evader_free and _encircled(evader, places)):
                break
        else:
            raise InputError("layout.evader_free: the evader is encircled at every start; move layout.evader or layout.pursuers")
        centre = middle(places)
        away = (2.0 * evader[0] - centre[0], 2.0 * evader[1] - centre[1])
        towards = away if self.goal_m is None else self.goal_m
        return self.pursuers.headed(places, evader), self.evader.headed([evader], towards)[0]

    def _chain(self, places: tuple[Place, ...]) -> list[list[float]]:
        rows = [disc(*places[0], self.chain_radius_m)]
        for (north, east), (to_north, to_east) in itertools.pairwise(places):
            count = math.ceil(math.dist((north, east), (to_north, to_east)) / (1.5 * self.chain_radius_m))
            step_n, step_e = (to_north - north) / count, (to_east - east) / count
            rows += [disc(north + step_n * k, east + step_e * k, self.chain_radius_m) for k in range(1, count + 1)]
        return rows

    def _clusters(self, starts: Array, standing: Array, random: np.random.Generator) -> list[list[float]]:
        """Discs of a third of the circle's radius, around its centre and in it."""
        circles = self._drawn(
            self.clusters, (self.cluster_radius_min_m, self.cluster_radius_max_m), starts, standing, "clusters", random
        )
        rows = []
        for north, east, radius in circles.tolist():
            small = radius / 3.0
            rows.append(disc(north, east, small))
            for direction, share in zip(
                random.uniform(-math.pi, math.pi, CLUSTER_DISCS), random.uniform(0.4, 1.0, CLUSTER_DISCS), strict=True
            ):
                way = float(share) * (radius - small)
                rows.append(disc(north + way * math.cos(direction), east + way * math.sin(direction), small))
        return rows

    def _field(self, starts: Array, standing: Array, random: np.random.Generator) -> Array:
        radii = (self.disc_radius_min_m, self.disc_radius_max_m)
        return self._drawn(self.discs, radii, starts, standing, "discs", random)

    def _drawn(
        self, count: int, radii: tuple[float, float], starts: Array, standing: Array, field: str, random: np.random.Generator
    ) -> Array:
        """Circles (count, 3) in the arena that leave room."""
        if count == 0:
            return np.zeros((0, 3))
        if min(self.arena_m[2] - self.arena_m[0], self.arena_m[3] - self.arena_m[1]) < 2.0 * radii[1] or radii[0] > radii[1]:
            raise InputError(f"layout.{field} = {count}: radii from {radii[0]:g} to {radii[1]:g} m do not fit into arena_m")
        free = starts if self.goal_m is None else np.concatenate((starts, np.array([self.goal_m])))
        low = (self.arena_m[0] + radii[1], self.arena_m[1] + radii[1], radii[0])
        high = (self.arena_m[2] - radii[1], self.arena_m[3] - radii[1], radii[1])
        around = np.concatenate((standing[:, :3], _circumscribed(self.polygons_m)))
        found = scattered(low, high, count, ATTEMPTS_MAX, free, self.start_clear_m, self.disc_gap_m, random, around)
        if len(found) < count:
            raise InputError(
                f"layout.{field} = {count}: only {len(found)} found room; fewer, smaller ones or a smaller disc_gap_m"
            )
        return found

    def _boundary(self) -> Boundary:
        if self.goal_m is not None:
            around = np.linspace(0.0, 2.0 * math.pi, GOAL_SIDES, endpoint=False)
            return Boundary(np.array(self.goal_m) + self.goal_radius_m * np.column_stack((np.cos(around), np.sin(around))), True)
        north, east, to_north, to_east = self.arena_m
        return Boundary(np.array([[north, east], [north, to_east], [to_north, to_east], [to_north, east]]), True)


def _is_convex(corners: tuple[Place, ...]) -> bool:
    """Whether every corner turns to the same side, and there is an area."""
    at = np.array(corners).reshape(-1, 2)
    along = np.roll(at, -1, axis=0) - at
    after = np.roll(along, -1, axis=0)
    turns = along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0]
    area = 0.5 * abs(float((at[:, 0] * np.roll(at[:, 1], -1) - at[:, 1] * np.roll(at[:, 0], -1)).sum()))
    bends = np.arctan2(turns, (along * after).sum(axis=1))
    return (
        len(at) >= 3
        and area > AREA_MIN_M2
        and abs(abs(float(bends.sum())) - 2.0 * math.pi) < 1e-6
        and bool((turns > 0.0).all() or (turns < 0.0).all())
    )


def _inscribed(circle: Array, random: np.random.Generator) -> Array:
    """A convex polygon (k, 2) of four to seven corners on `circle` (3,), its centre inside."""
    count = int(random.integers(4, 8))
    shares = (np.arange(count) + random.uniform(-0.25, 0.25, count) + float(random.uniform())) * 2.0 * math.pi / count
    corners: Array = circle[:2] + circle[2] * np.column_stack((np.cos(shares), np.sin(shares)))
    return corners


def _circumscribed(polygons: tuple[tuple[Place, ...], ...]) -> Array:
    """(k, 3): circles around polygons."""
    rows = []
    for corners in polygons:
        centre = middle(corners)
        rows.append((*centre, max(math.dist(centre, corner) for corner in corners)))
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _encircled(evader: Place, pursuers: list[Place]) -> bool:
    bearings = np.array([math.atan2(east - evader[1], north - evader[0]) for north, east in pursuers])
    return len(pursuers) >= 3 and widest_gap_rad(bearings) < math.pi


def _check_starts(starts: tuple[Start, ...], discs: Array, polygons: list[Array], room_m: float) -> None:
    """InputError where a vehicle starts in an obstacle."""
    walls = edge_rows(polygons)
    for start in starts:
        place = (start.north_m, start.east_m)
        gaps = np.hypot(discs[:, 0] - place[0], discs[:, 1] - place[1]) - discs[:, 2]
        edges = [wall_distance_m(*place, *edge) for edge in walls.tolist()]
        if min([*gaps.tolist(), *edges], default=math.inf) < room_m or any(_inside(place, polygon) for polygon in polygons):
            raise InputError(
                f"layout: a vehicle starts at {place[0]:g}, {place[1]:g} less than {room_m:g} m from an obstacle; move one"
            )


def _inside(place: Place, polygon: Array) -> bool:
    along = np.roll(polygon, -1, axis=0) - polygon
    to = np.array(place) - polygon
    sides = along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0]
    return bool((sides > 0.0).all() or (sides < 0.0).all())
