"""Evader policy `straight`: to the nearest boundary point, with Gaussian noise on the heading (the source's evader)."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.boundary_run import BoundaryRun
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import StraightParameters
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import planar


class Straight:
    """Ignores obstacles and pursuers; beyond the boundary it stands."""

    def __init__(self, *, limits: Limits, parameters: StraightParameters, seed: int = 0) -> None:
        self._speed_max_m_s = limits.speed_max_m_s
        self._parameters = parameters
        self._seed = seed
        self.reset(seed)

    def reset(self, seed: int | None = None) -> None:
        """Forget the crossing and start the noise anew, from `seed` if given."""
        self._seed = self._seed if seed is None else seed
        self._random = np.random.default_rng(self._seed)
        self._run = BoundaryRun()
        self._error_rad = 0.0
        self._renew_s = -math.inf

    def step(self, observation: Observation) -> Decision:
        goal = self._run.goal(observation)
        if self._run.crossed:
            return decision(observation, (0.0, 0.0), goal, "crossed", self._speed_max_m_s)
        if observation.t_s >= self._renew_s:
            self._error_rad = float(self._random.normal(0.0, math.radians(self._parameters.heading_noise_deg)))
            self._renew_s = observation.t_s + self._parameters.noise_period_s
        north, east = self._run.direction(planar(observation.own.position_ned_m), goal)
        heading = math.atan2(east, north) + self._error_rad
        velocity = (self._speed_max_m_s * math.cos(heading), self._speed_max_m_s * math.sin(heading))
        return decision(observation, velocity, goal, "straight", self._speed_max_m_s)


def build(name: str, limits: Limits, given: Given, seed: int) -> Planner:
    """As the registry asks for it."""
    return Straight(limits=limits, parameters=parsed(StraightParameters, name, given), seed=seed)
