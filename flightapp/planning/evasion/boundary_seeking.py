"""Evader policy `boundary-seeking`: to the boundary, around obstacles and, weakly, away from pursuers."""

from __future__ import annotations

import math

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.boundary_run import BoundaryRun
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import BoundarySeekingParameters
from flightapp.planning.evasion.pursuers import pursuer_rows
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, planar, towards, unit


class BoundarySeeking:
    """The pursuers arrive as the observation's team. Beyond the boundary it stands."""

    def __init__(self, *, limits: Limits, parameters: BoundarySeekingParameters) -> None:
        self._speed_max_m_s = limits.speed_max_m_s
        self._parameters = parameters
        self._avoidance = Avoidance(limits, parameters)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget the crossing."""
        del seed
        self._run = BoundaryRun()

    def step(self, observation: Observation) -> Decision:
        own = planar(observation.own.position_ned_m)
        goal = self._run.goal(observation)
        pursuers = pursuer_rows(observation)
        speed = 0.0 if self._run.crossed else self._speed_max_m_s
        north, east = self._away_from(pursuers, own, self._run.direction(own, goal))
        velocity = self._avoidance.velocity(observation, own, pursuers, (speed * north, speed * east))
        mode = "crossed" if self._run.crossed else "boundary-seeking"
        return decision(observation, velocity, goal, mode, self._speed_max_m_s)

    def _away_from(self, pursuers: Array, own: Point, direction: Point) -> Point:
        """`direction`, pushed weakly away from near pursuers."""
        north, east = direction
        for place_n, place_e, _, _ in pursuers.tolist():
            nearness = 1.0 - math.dist(own, (place_n, place_e)) / self._parameters.pursuer_influence_m
            if nearness > 0.0:
                push = towards((place_n, place_e), own)
                north += self._parameters.pursuer_gain * nearness * push[0]
                east += self._parameters.pursuer_gain * nearness * push[1]
        return unit((north, east))


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return BoundarySeeking(limits=limits, parameters=parsed(BoundarySeekingParameters, name, given))
