"""Evader policy `waypoints`: flies a list of points and stands at the last."""

from __future__ import annotations

import math

from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import WaypointsParameters
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import planar, towards


class Waypoints:
    """From waypoint to waypoint at full speed."""

    def __init__(self, *, limits: Limits, parameters: WaypointsParameters) -> None:
        self._speed_max_m_s = limits.speed_max_m_s
        self._arrival_m = parameters.arrival_m
        values = parameters.waypoints
        self._places = tuple(zip(values[::2], values[1::2], strict=True))
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Start at the first waypoint again."""
        del seed
        self._next = 0

    def step(self, observation: Observation) -> Decision:
        own = planar(observation.own.position_ned_m)
        while self._next < len(self._places) - 1 and math.dist(own, self._places[self._next]) < self._arrival_m:
            self._next += 1
        place = self._places[self._next]
        last = self._next == len(self._places) - 1
        speed = min(self._speed_max_m_s, math.dist(own, place)) if last else self._speed_max_m_s
        direction = towards(own, place)
        return decision(observation, (speed * direction[0], speed * direction[1]), place, "waypoints", self._speed_max_m_s)


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Waypoints(limits=limits, parameters=parsed(WaypointsParameters, name, given))
