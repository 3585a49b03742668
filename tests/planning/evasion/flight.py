"""One evader with a velocity lag among pursuers that are moved by the test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flightapp.core.types import (
    Array,
    Boundary,
    Decision,
    Limits,
    Observation,
    ObstacleSet,
    TeamMember,
    VehicleState,
)
from flightapp.planning.api import Planner
from flightapp.planning.plane import Point, crosses, planar, segments

DT_S = 0.1
LAG_S = 0.25
LIMITS = Limits(4.0, 6.0, 60.0, 3.0, 12.0, 2.0, 0.25, 0.25)
LINE = Boundary(np.array([[0.0, -30.0], [0.0, 30.0]]), False)

Pursuit = Callable[[Array, Point], Array]


def disc(north: float, east: float, radius: float) -> list[float]:
    return [north, east, radius, 0.0, 0.0, -np.inf, np.inf]


def observation(
    t_s: float,
    own: Point,
    velocity: Point = (0.0, 0.0),
    *,
    pursuers: Array | None = None,
    discs: list[list[float]] | None = None,
    boundary: Boundary = LINE,
) -> Observation:
    """What the evader at `own` knows; pursuers: (k, 4)."""
    team = tuple(
        TeamMember(f"p{k}", VehicleState(t_s, np.array((n, e, -5.0)), np.array((vn, ve, 0.0)), 0.0), "coarse", None, 0.05)
        for k, (n, e, vn, ve) in enumerate(np.zeros((0, 4)) if pursuers is None else pursuers)
    )
    state = VehicleState(t_s, np.array((*own, -5.0)), np.array((*velocity, 0.0)), 0.0)
    obstacles = ObstacleSet(t_s, np.array(discs or []).reshape(-1, 7), np.zeros((0, 2)))
    return Observation(t_s, DT_S, state, team, None, obstacles, boundary)


@dataclass
class Flight:
    """What happened, one entry a step."""

    path: list[Point] = field(default_factory=list)
    decisions: list[Decision] = field(default_factory=list)
    crossed_s: float | None = None
    clearance_m: float = np.inf
    """Least distance of the body from a disc."""
    distance_m: float = np.inf
    """Least distance from a pursuer."""


def standing(pursuers: Array, _evader: Point) -> Array:
    """Pursuers that stay where they are."""
    return pursuers


def chasing(speed_m_s: float) -> Pursuit:
    """Pursuers that fly straight at the evader."""

    def move(pursuers: Array, evader: Point) -> Array:
        way = np.array(evader) - pursuers[:, :2]
        pursuers[:, 2:] = speed_m_s * way / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
        pursuers[:, :2] += DT_S * pursuers[:, 2:]
        return pursuers

    return move


def fly(
    evader: Planner,
    start: Point,
    seconds: float,
    *,
    pursuers: list[tuple[float, float]] | None = None,
    pursuit: Pursuit = standing,
    discs: list[list[float]] | None = None,
    boundary: Boundary = LINE,
) -> Flight:
    """Fly `evader` from `start` until it crosses the boundary, at most `seconds`."""
    place, velocity = np.array(start), np.zeros(2)
    team = np.array([(*where, 0.0, 0.0) for where in pursuers or []]).reshape(-1, 4)
    sides, flight = segments(boundary), Flight()
    for tick in range(round(seconds / DT_S)):
        own = planar(place)
        seen = observation(tick * DT_S, own, planar(velocity), pursuers=team, discs=discs, boundary=boundary)
        flight.path.append(own)
        flight.decisions.append(evader.step(seen))
        for north, east, radius, *_ in discs or []:
            gap = float(np.hypot(place[0] - north, place[1] - east)) - radius - LIMITS.body_radius_m
            flight.clearance_m = min(flight.clearance_m, gap)
        if len(team):
            flight.distance_m = min(flight.distance_m, float(np.hypot(*(team[:, :2] - place).T).min()))
        velocity += (flight.decisions[-1].velocity_ned_m_s[:2] - velocity) * DT_S / LAG_S
        place += velocity * DT_S
        team = pursuit(team, planar(place))
        if crosses(own, planar(place), sides):
            flight.crossed_s = (tick + 1) * DT_S
            flight.path.append(planar(place))
            flight.decisions.append(evader.step(observation((tick + 1) * DT_S, planar(place), boundary=boundary)))
            return flight
    return flight
