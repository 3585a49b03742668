"""Ways around what is known: planned in three dimensions from where the vehicle is, inside the fence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from shapely.geometry import Point, Polygon

from flightapp.config.known_obstacles import KnownBox, KnownCylinder, KnownObstacle
from flightapp.config.mission import FlightVolume
from flightapp.core.types import Array, ObstacleSet
from flightapp.planning.path_planning.api import Budget, Problem
from flightapp.planning.path_planning.flight import plan_flight
from flightapp.planning.path_planning.registry import make_path_planner
from flightapp.planning.path_planning.trajectory import FlightLimits, Trajectory
from flightapp.runtime.composition import feeds_forward
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.way_follower import WayFollower
from flightapp.safety.heights import STANDS_M_S
from flightapp.space.bodies import BOTTOM, TOP, V_DOWN, V_NORTH
from flightapp.space.contact import first_contact
from flightapp.space.shapes import Cylinder, OrientedBox, Shape, Sphere, bodies_of, bodies_of_discs, no_bodies
from flightapp.space.world import World

ITERATIONS = 3000
COMPUTING_S = 0.15
"""After which no more iterations are made. What comes before and after may take as long in a large world of many bodies."""
TRACKING_M = 1.0
"""Room for how far the vehicle may be from where it is to be, beside body and safety margin."""
SPEED_SHARE = 0.8
"""Of the speed limit: catching up needs the rest."""
FENCE_M = 0.1
BAND_M = 0.3
"""Kept from the lowest and highest flight height."""


@dataclass(frozen=True, slots=True)
class PlannedWay:
    """What came of planning a way for `purpose`: a trajectory, or none and why."""

    purpose: str
    trajectory: Trajectory | None
    text: str
    gap_m: float


class WayPlanner:
    """Plans ways of one vehicle, and says which straight ways are clear of everything that is known and seen.

    What is seen to move counts as endless in height, as for the guards: a way over it would be stopped by them.
    """

    def __init__(self, rooms: Rooms) -> None:
        mission, limits = rooms.mission, rooms.limits
        volume = mission.flight_volume
        self._clock = rooms.clock
        self._known = bodies_of(shape_of(one) for one in mission.known_obstacles)
        self._fence = bodies_of(_fence(volume))
        self._inside = Polygon(volume.vertices_m)
        vertices = np.array(volume.vertices_m)
        self._low = np.array((*vertices.min(axis=0), BAND_M - volume.height_max_m))
        self._high = np.array((*vertices.max(axis=0), -volume.height_min_m - BAND_M))
        self._gap_min_m = limits.body_radius_m + limits.safety_margin_m
        self._limits = limits
        self._flight_limits = FlightLimits(
            SPEED_SHARE * limits.speed_max_m_s,
            SPEED_SHARE * min(limits.climb_rate_max_m_s, limits.sink_rate_max_m_s),
            limits.acceleration_max_m_s2,
        )
        self._planner = make_path_planner("rrt-star-apf")
        self._seed = rooms.vehicle.system_id
        self._feed_forward = feeds_forward(mission, rooms.profile)

    def plan(self, purpose: str, start: Array, goal: Array, seen: ObstacleSet, attempt: int = 0) -> PlannedWay:
        """From `start` to `goal` (3,), past what is known and what is seen now. Takes 0.03 to 0.5 s: in a thread.

        purpose: as a person calls the way. Both ends are brought into the flight volume's box first.
        """
        try:
            return self._planned(purpose, self.within(start), self.within(goal), seen, attempt)
        except Exception as error:  # Whoever asks must bring the vehicle somewhere: that there is no way is an answer.
            return PlannedWay(purpose, None, f"no {purpose}: the planner failed, {type(error).__name__}: {error}", math.nan)

    def _planned(self, purpose: str, start: Array, goal: Array, seen: ObstacleSet, attempt: int) -> PlannedWay:
        gap = self._gap_min_m + TRACKING_M
        problem = Problem(
            self._world(start, seen),
            start,
            goal,
            self._low,
            self._high,
            gap,
            gap,
            speed_max_m_s=self._flight_limits.speed_max_m_s,
            acceleration_max_m_s2=self._flight_limits.acceleration_max_m_s2,
        )
        until_s = self._clock.now_s() + COMPUTING_S
        budget = Budget(ITERATIONS, lambda: self._clock.now_s() < until_s)
        flight = plan_flight(problem, self._planner, budget, self._seed + attempt, self._flight_limits, self._gap_min_m)
        if flight.trajectory is None:
            return PlannedWay(purpose, None, f"no {purpose} around what is known: {flight.reason}", flight.gap_m)
        length, direct = flight.trajectory.length_m, math.dist(start, goal)
        lasts = flight.trajectory.duration_s
        text = f"{purpose} of {length:.0f} m ({direct:.0f} m straight) in {lasts:.0f} s, {flight.gap_m:g} m clear"
        return PlannedWay(purpose, flight.trajectory, text, flight.gap_m)

    def follower(self, trajectory: Trajectory) -> WayFollower:
        return WayFollower(trajectory, self._limits, feed_forward=self._feed_forward)

    def within(self, place: Array) -> Array:
        """The nearest place (3,) in the box around the flight volume that ways lead through."""
        return np.clip(place, self._low, self._high)

    def is_clear(self, seen: ObstacleSet, *places: Array) -> bool:
        """Whether the straight ways between each two `places` (3,) keep body and safety margin. Some 10 us a hundred bodies."""
        bodies = np.vstack((self._known, _standing(seen)))
        for (north, east, down), (along_n, along_e, along_d) in ((a.tolist(), (b - a).tolist()) for a, b in pairwise(places)):
            if first_contact(bodies, north, east, down, along_n, along_e, along_d, 0.0, self._gap_min_m, 1.0)[1] >= 0:
                return False
        return True

    def _world(self, here: Array, seen: ObstacleSet) -> World:
        """Known bodies, the fence seen from inside, and seen discs where they are now; what moves is left to the guards."""
        fence = self._fence if self._inside.contains(Point(here[0], here[1])) else no_bodies()
        return World.of_bodies(np.vstack((self._known, fence, _standing(seen))))


def _standing(seen: ObstacleSet) -> Array:
    """Rows of what is seen, where it is now."""
    discs = bodies_of_discs(seen.discs)
    moving = np.hypot(discs[:, V_NORTH], discs[:, V_NORTH + 1]) > STANDS_M_S
    discs[moving, TOP], discs[moving, BOTTOM] = -np.inf, np.inf
    discs[:, V_NORTH : V_DOWN + 1] = 0.0
    return discs


def shape_of(known: KnownObstacle) -> Shape:
    """A known obstacle of a mission file, with heights above the datum, as a body in NED."""
    if isinstance(known, KnownCylinder):
        return Cylinder(known.north_m, known.east_m, known.radius_m, *_extent(known.bottom_m, known.top_m))
    if isinstance(known, KnownBox):
        extent = _extent(known.bottom_m, known.top_m)
        return OrientedBox(known.north_m, known.east_m, known.length_m, known.width_m, *extent, math.radians(known.heading_deg))
    return Sphere(known.north_m, known.east_m, -known.height_m, known.radius_m)


def _extent(bottom_m: float | None, top_m: float | None) -> tuple[float, float]:
    """(down of the top, down of the bottom)."""
    return (-math.inf if top_m is None else -top_m), (math.inf if bottom_m is None else -bottom_m)


def _fence(volume: FlightVolume) -> Sequence[Shape]:
    """A thin wall along every edge of the flight volume: no way leads out of it and in again."""
    vertices = np.array(volume.vertices_m)
    return [_wall(start, end) for start, end in zip(vertices, np.roll(vertices, -1, axis=0), strict=True)]


def _wall(start: Array, end: Array) -> OrientedBox:
    middle, along = 0.5 * (start + end), end - start
    length, heading = math.hypot(along[0], along[1]), math.atan2(along[1], along[0])
    return OrientedBox(float(middle[0]), float(middle[1]), length, FENCE_M, heading_rad=heading)
