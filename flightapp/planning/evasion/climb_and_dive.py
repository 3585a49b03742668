"""Evader policy `climb-and-dive`: boundary-seeking that climbs and dives on its way, to shake off pursuers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.boundary_seeking import BoundarySeeking
from flightapp.planning.evasion.parameters import ClimbAndDiveParameters
from flightapp.planning.parameters import parsed

PARAMETERS = ClimbAndDiveParameters
TURNED_M = 0.3
"""This near to a height the other one is next."""


class ClimbAndDive:
    """Turns round at each height and, against its present direction, whenever a pursuer comes within `dodge_m` in space.

    In the plane it avoids all obstacles, whatever their height.
    """

    def __init__(self, *, limits: Limits, parameters: ClimbAndDiveParameters) -> None:
        self._planar = BoundarySeeking(limits=limits, parameters=parameters)
        self._parameters = parameters
        self._climb_m_s = min(parameters.climb_rate_m_s, limits.climb_rate_max_m_s)
        self._sink_m_s = min(parameters.climb_rate_m_s, limits.sink_rate_max_m_s)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget the crossing; the first way is up."""
        self._planar.reset(seed)
        self._climbs, self._was_near, self._down_m_s = True, False, 0.0

    def step(self, observation: Observation) -> Decision:
        p, height = self._parameters, -float(observation.own.position_ned_m[2])
        self._turn(observation, height)
        aim = p.height_high_m if self._climbs else p.height_low_m
        gap = height - aim
        rate_max = self._sink_m_s if gap > 0.0 else self._climb_m_s
        rate = math.copysign(min(rate_max, braking_speed_m_s(abs(gap), p.climb_acceleration_m_s2, 0.0)), gap)
        change = p.climb_acceleration_m_s2 * observation.dt_s
        self._down_m_s = min(self._down_m_s + change, max(self._down_m_s - change, rate))
        decision = self._planar.step(observation)
        velocity = np.array((*decision.velocity_ned_m_s[:2], self._down_m_s))
        return replace(decision, velocity_ned_m_s=velocity, flies_height=True)

    def _turn(self, observation: Observation, height_m: float) -> None:
        """Which way is next."""
        p, place = self._parameters, observation.own.position_ned_m
        if abs(height_m - (p.height_high_m if self._climbs else p.height_low_m)) <= TURNED_M:
            self._climbs = not self._climbs
        near = any(float(np.linalg.norm(one.state.position_ned_m - place)) < p.dodge_m for one in observation.team)
        if near and not self._was_near:
            self._climbs = not self._climbs
        self._was_near = near


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return ClimbAndDive(limits=limits, parameters=parsed(ClimbAndDiveParameters, name, given))
