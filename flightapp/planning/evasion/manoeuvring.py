"""Evader policy `manoeuvring`: to the boundary as one that is hunted may fly: weaving, fleeing for a while, faster all at once.

The target of the hunting paper (Li et al. 2025) drives to its goal and does not look at pursuers; so does this one where no
manoeuvre is asked for. The manoeuvres break a prediction from its past each in another way, and can be combined.
"""

from __future__ import annotations

import math

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.boundary_run import BoundaryRun
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.inverse_square import repelled
from flightapp.planning.evasion.parameters import ManoeuvringParameters
from flightapp.planning.evasion.pursuers import pursuer_rows
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, planar, unit

PARAMETERS = ManoeuvringParameters


class Manoeuvring:
    """The pursuers arrive as the observation's team. Beyond the boundary it stands."""

    def __init__(self, *, limits: Limits, parameters: ManoeuvringParameters) -> None:
        self._limits, self._parameters = limits, parameters
        self._avoidance = Avoidance(limits, parameters)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget the crossing and when it began."""
        del seed
        self._run = BoundaryRun()
        self._began_s: float | None = None

    def step(self, observation: Observation) -> Decision:
        self._began_s = observation.t_s if self._began_s is None else self._began_s
        flown_s = observation.t_s - self._began_s
        own, pursuers = planar(observation.own.position_ned_m), pursuer_rows(observation)
        goal = self._run.goal(observation)
        if self._run.crossed:
            return decision(observation, (0.0, 0.0), goal, "crossed", self._limits.speed_max_m_s)
        flees = self._flees(own, pursuers)
        n, e = unit(repelled(own, pursuers)) if flees else self._woven(self._run.direction(own, goal), flown_s)
        speed = self._speed_m_s(flown_s)
        velocity = self._avoidance.velocity(observation, own, pursuers, (speed * n, speed * e))
        return decision(observation, velocity, goal, "fleeing" if flees else "manoeuvring", speed)

    def _flees(self, own: Point, pursuers: Array) -> bool:
        return any(math.dist(own, (row[0], row[1])) < self._parameters.flee_within_m for row in pursuers.tolist())

    def _woven(self, direction: Point, flown_s: float) -> Point:
        """`direction`, turned to the one side and to the other."""
        turn = math.radians(self._parameters.weave_deg) * math.sin(2.0 * math.pi * flown_s / self._parameters.weave_period_s)
        cos, sin = math.cos(turn), math.sin(turn)
        return direction[0] * cos - direction[1] * sin, direction[0] * sin + direction[1] * cos

    def _speed_m_s(self, flown_s: float) -> float:
        top = self._limits.speed_max_m_s
        return top if flown_s >= self._parameters.jump_s else min(top, self._parameters.speed_before_m_s or top)


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Manoeuvring(limits=limits, parameters=parsed(ManoeuvringParameters, name, given))
