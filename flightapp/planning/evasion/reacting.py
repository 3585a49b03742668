"""Evader policies that know where to flee: the direction is theirs, the way around obstacles and the area's edge is shared."""

from __future__ import annotations

import math
from collections.abc import Callable

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import ReactingParameters
from flightapp.planning.evasion.pursuers import pursuer_rows
from flightapp.planning.plane import Point, planar, towards, unit

DIRECTIONS = tuple((math.cos(k * math.pi / 8.0), math.sin(k * math.pi / 8.0)) for k in range(16))

Direction = Callable[[Point, Array], Point]
"""(own place, pursuers (k > 0, 4)) -> where to flee; its length does not matter."""


class Reacting:
    """Full speed where the policy says, along obstacles and along the edge of the area. Without pursuers it stands."""

    def __init__(self, name: str, limits: Limits, parameters: ReactingParameters, direction: Direction) -> None:
        self._name, self._speed_max_m_s, self._direction = name, limits.speed_max_m_s, direction
        self._area, self._edge_s = parameters.area_m, parameters.edge_s
        self._avoidance = Avoidance(limits, parameters)

    def reset(self, seed: int | None = None) -> None:
        """Nothing to forget."""
        del seed

    def step(self, observation: Observation) -> Decision:
        own, pursuers = planar(observation.own.position_ned_m), pursuer_rows(observation)
        n, e = unit(self._direction(own, pursuers)) if len(pursuers) else (0.0, 0.0)
        wish = self._within_area(own, (self._speed_max_m_s * n, self._speed_max_m_s * e))
        velocity = self._avoidance.velocity(observation, own, pursuers, wish)
        return decision(observation, velocity, None, self._name, self._speed_max_m_s)

    def _within_area(self, own: Point, wish: Point) -> Point:
        """`wish`; where it would soon leave the area, the direction nearest to it that does not; from outside, back."""
        if self._area is None or self._stays(own, wish):
            return wish
        turns = [(self._speed_max_m_s * n, self._speed_max_m_s * e) for n, e in DIRECTIONS]
        kept = [turn for turn in turns if self._stays(own, turn)]
        if kept:
            return max(kept, key=lambda turn: turn[0] * wish[0] + turn[1] * wish[1])
        middle = (0.5 * (self._area[0] + self._area[2]), 0.5 * (self._area[1] + self._area[3]))
        n, e = towards(own, middle)
        return self._speed_max_m_s * n, self._speed_max_m_s * e

    def _stays(self, own: Point, velocity: Point) -> bool:
        if self._area is None:
            return True
        n, e = own[0] + self._edge_s * velocity[0], own[1] + self._edge_s * velocity[1]
        return self._area[0] < n < self._area[2] and self._area[1] < e < self._area[3]
