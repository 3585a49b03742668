"""What the formation is to fly: the leader's planned way, and beside and behind it the places of its followers.

The source gives no offsets, and plans for the leader alone: its followers fly through obstacles. Here they fly in a V as long as
all of it keeps the gap from every body, then astern of the leader, on its own checked way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.ndimage import gaussian_filter1d

from flightapp.core.types import Array
from flightapp.planning.path_planning.api import Budget, Problem
from flightapp.planning.path_planning.flight import plan_flight
from flightapp.planning.path_planning.registry import make_path_planner
from flightapp.planning.path_planning.trajectory import FlightLimits, Trajectory
from flightapp.space.random_scene import random_scene
from flightapp.space.world import World

SPACING_S = 0.01
GAP_M = 2.25
"""Hull 0.25 m, safety 1 m, tracking error 1 m."""
WEDGE_M = ((-5.0, 5.0), (-5.0, -5.0), (-10.0, 10.0), (-10.0, -10.0))
"""Forward and right of the leader."""
ASTERN_M = 6.0
"""Between two in the column: on the way from V to column every pair stays 5 m apart."""
CHANGE_S = 8.0
"""From V to column: slow enough for the last one, who falls 14 m back, to need less than 2 m/s^2 for that."""
HEADING_S = 0.5
CHECKED_EVERY = 10
ITERATIONS = 5000
SPEED_M_S, ACCELERATION_M_S2 = 10.0, 3.0
"""Cruising speed, and half of what the vehicles can do: the other half is for wind and errors."""


@dataclass(frozen=True, slots=True)
class Course:
    """references (n, m, 9): position, velocity, acceleration of leader and followers every SPACING_S, NED; what is around them.

    wedge_share: of the time in the V. length_m, duration_s: of the leader's way.
    """

    references: Array
    bodies: Array
    length_m: float
    duration_s: float
    wedge_share: float


def plan_course(seed: int, way: str, obstacles: int, step_m: float, followers: int) -> Course | str:
    """The course of scene `seed`, or why there is none."""
    scene = random_scene(seed, way, obstacles)
    world = World.of(scene.shapes)
    problem = Problem(world, scene.start_ned_m, scene.goal_ned_m, scene.low_ned_m, scene.high_ned_m, GAP_M, GAP_M, 0.0, SPEED_M_S)
    planner = make_path_planner("rrt-star-apf", {"step_m": step_m})
    limits = FlightLimits(SPEED_M_S, SPEED_M_S, ACCELERATION_M_S2)
    flight = plan_flight(problem, planner, Budget(ITERATIONS), seed, limits)
    if flight.trajectory is None:
        return flight.reason
    references, wedge_share = formation_references(flight.trajectory, world, followers)
    return Course(references, world.bodies, flight.trajectory.length_m, flight.trajectory.duration_s, wedge_share)


def formation_references(leader: Trajectory, world: World, followers: int) -> tuple[Array, float]:
    """references (1 + followers, m, 9), and the share of the time that the followers spend in their V."""
    times = np.arange(0.0, leader.duration_s + SPACING_S, SPACING_S)
    rows = _sampled(leader, times)
    places = rows[:, :3]
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    ahead, right = _axes(places, along)
    wedge = [places + f * ahead + r * right for f, r in WEDGE_M[:followers]]
    astern = [_behind(places, along, (rank + 1) * ASTERN_M) for rank in range(followers)]
    mixed = _mixing(wedge, astern, world)
    slots = [(1.0 - mixed) * w + mixed * a for w, a in zip(wedge, astern, strict=True)]
    return np.ascontiguousarray(np.stack([rows, *map(_moving, slots)])), float((mixed < 0.01).mean())


def _sampled(way: Trajectory, times_s: Array) -> Array:
    """(m, 9): position, velocity, acceleration of `way` as its `at` gives them, all at once."""
    cubic = CubicHermiteSpline(way.times_s, way.positions_ned_m, way.velocities_ned_m_s)
    rows = np.concatenate([cubic(np.minimum(times_s, way.duration_s), order) for order in range(3)], axis=1)
    rows[times_s >= way.duration_s, 3:] = 0.0
    return np.asarray(rows, dtype=np.float64)


def _axes(places: Array, along: Array) -> tuple[Array, Array]:
    """Unit vectors ahead in the plane and to the right (m, 3), by the low-passed heading."""
    before, after = (np.stack([np.interp(along + by, along, places[:, axis]) for axis in (0, 1)], 1) for by in (-1.0, 1.0))
    steps = gaussian_filter1d(after - before, HEADING_S / SPACING_S, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-9)
    zeros = np.zeros(len(places))
    return np.stack((steps[:, 0], steps[:, 1], zeros), 1), np.stack((-steps[:, 1], steps[:, 0], zeros), 1)


def _behind(places: Array, along: Array, gap_m: float) -> Array:
    """Where the way was `gap_m` before; before its beginning it is straight."""
    wanted = along - gap_m
    inside = np.stack([np.interp(wanted, along, places[:, axis]) for axis in range(3)], 1)
    first = places[np.searchsorted(along, 0.5).clip(1, len(places) - 1)] - places[0]
    first = first / max(float(np.linalg.norm(first)), 1e-9)
    return np.asarray(inside + np.minimum(wanted, 0.0)[:, None] * first, dtype=np.float64)


def _mixing(wedge: list[Array], astern: list[Array], world: World) -> Array:
    """(m, 1): 0 in the V, 1 in the column. They change once, early enough, where the V would come too near to a body.

    Back into the V they would have to fly faster than the leader for as long again.
    """
    count = len(wedge[0])
    checked = np.arange(0, count, CHECKED_EVERY)
    tight = np.zeros(count)
    for k in checked:
        for w, a in zip(wedge, astern, strict=True):
            places = (w[k], 0.5 * (w[k] + a[k]))
            if min(world.signed_distance_m(place) for place in places) < GAP_M:
                tight[k : k + CHECKED_EVERY] = 1.0
                break
    if not tight.any():
        return tight[:, None]
    since = (np.arange(count) - int(tight.argmax())) * SPACING_S / CHANGE_S + 1.0
    phase = np.clip(since, 0.0, 1.0)
    return np.asarray((phase - np.sin(2.0 * np.pi * phase) / (2.0 * np.pi))[:, None], dtype=np.float64)


def _moving(slots: Array) -> Array:
    """(m, 9): the places (m, 3), smoothed a little, with velocity and acceleration."""
    smooth = gaussian_filter1d(slots, 0.1 / SPACING_S, axis=0, mode="nearest")
    velocities = np.gradient(smooth, SPACING_S, axis=0)
    return np.concatenate((smooth, velocities, np.gradient(velocities, SPACING_S, axis=0)), 1)
