"""Evader policy `random-waypoints`: from one random place of an area to the next, whatever the pursuers do."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import RandomWaypointsParameters
from flightapp.planning.evasion.pursuers import pursuer_rows
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, planar, towards

PARAMETERS = RandomWaypointsParameters


class RandomWaypoints:
    """A place that is not reached in time, as within an obstacle, is given up."""

    def __init__(self, *, limits: Limits, parameters: RandomWaypointsParameters, seed: int) -> None:
        self._speed_max_m_s, self._parameters, self._seed = limits.speed_max_m_s, parameters, seed
        self._avoidance = Avoidance(limits, parameters)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Start over, from `seed` if given."""
        self._seed = self._seed if seed is None else seed
        self._random = np.random.default_rng(self._seed)
        self._place: Point | None = None
        self._until_s = -math.inf

    def step(self, observation: Observation) -> Decision:
        own = planar(observation.own.position_ned_m)
        place = self._place
        if place is None or math.dist(own, place) < self._parameters.arrival_m or observation.t_s >= self._until_s:
            place = self._place = self._next()
            self._until_s = observation.t_s + 2.0 * math.dist(own, place) / self._speed_max_m_s
        n, e = towards(own, place)
        wish = (self._speed_max_m_s * n, self._speed_max_m_s * e)
        velocity = self._avoidance.velocity(observation, own, pursuer_rows(observation), wish)
        return decision(observation, velocity, place, "random-waypoints", self._speed_max_m_s)

    def _next(self) -> Point:
        north_min, east_min, north_max, east_max = self._parameters.area_m
        return float(self._random.uniform(north_min, north_max)), float(self._random.uniform(east_min, east_max))


def build(name: str, limits: Limits, given: Given, seed: int) -> Planner:
    """As the registry asks for it."""
    return RandomWaypoints(limits=limits, parameters=parsed(RandomWaypointsParameters, name, given), seed=seed)
