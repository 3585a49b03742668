"""Evader policy `adversarial`: the best response in the interception game on Apollonius regions."""

from __future__ import annotations

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.ac2f.apollonius import solve
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.boundary_run import BoundaryRun
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import AdversarialParameters
from flightapp.planning.evasion.pursuers import pursuer_rows
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, planar


class Adversarial:
    """Goes where it reaches the boundary first; where it does so nowhere, to the point of its region nearest to the boundary."""

    def __init__(self, *, limits: Limits, parameters: AdversarialParameters) -> None:
        self._speed_max_m_s = limits.speed_max_m_s
        self._speed_ratio = parameters.pursuer_speed_assumed_m_s / limits.speed_max_m_s
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
        if not self._run.crossed and len(pursuers):
            goal = self._best_response(observation, own, pursuers)
        speed = 0.0 if self._run.crossed else self._speed_max_m_s
        north, east = self._run.direction(own, goal)
        velocity = self._avoidance.velocity(observation, own, pursuers, (speed * north, speed * east))
        mode = "crossed" if self._run.crossed else "adversarial"
        return decision(observation, velocity, goal, mode, self._speed_max_m_s)

    def _best_response(self, observation: Observation, own: Point, pursuers: Array) -> Point:
        """The game point (m): on the boundary where the evader reaches it first, else the best that it can hold."""
        places = pursuers[:, :2].tolist()
        ratios = [self._speed_ratio] * len(places)
        return solve(places, own, ratios, self._run.edge.rows, closed=observation.boundary.closed).point


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Adversarial(limits=limits, parameters=parsed(AdversarialParameters, name, given))
