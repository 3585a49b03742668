"""Evader policy `boundary-seeking`: to the boundary, around obstacles and, weakly, away from pursuers."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.ac2f.potential_field import FieldParameters, deflected, safe_velocity
from flightapp.planning.ac2f.scene import Mover, build_scene
from flightapp.planning.ac2f.surroundings import teammate_now
from flightapp.planning.evasion.command import BoundaryRun, decision
from flightapp.planning.evasion.parameters import BoundarySeekingParameters
from flightapp.planning.plane import Point, planar, towards, unit

NO_TRAIL = np.zeros((0, 2))


class BoundarySeeking:
    """The pursuers arrive as the observation's team. Beyond the boundary it stands."""

    def __init__(self, *, limits: Limits, parameters: BoundarySeekingParameters) -> None:
        self._limits = limits
        self._parameters = parameters
        self._field = FieldParameters(
            parameters.field_gain_m2,
            parameters.field_influence_m,
            parameters.field_repulsion_max,
            limits.acceleration_max_m_s2 * parameters.braking_share,
            parameters.reaction_s,
        )
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget the crossing."""
        del seed
        self._run = BoundaryRun()
        self._direction: Point = (0.0, 0.0)

    def step(self, observation: Observation) -> Decision:
        own, velocity = planar(observation.own.position_ned_m), planar(observation.own.velocity_ned_m_s)
        goal = self._run.goal(observation)
        if math.dist(own, goal) > 0.5:
            self._direction = towards(own, goal)
        pursuers = [teammate_now(member) for member in observation.team]
        speed = 0.0 if self._run.crossed else self._limits.speed_max_m_s
        direction = self._away_from(own, [place for place, _ in pursuers])
        obstacles = self._scene(observation, own, [])
        wish = deflected(obstacles, own, (speed * direction[0], speed * direction[1]), self._field)
        movers = [Mover(place, drift, self._parameters.pursuer_distance_m) for place, drift in pursuers]
        scene = self._scene(observation, own, movers)
        chosen = safe_velocity(scene, own, wish, velocity, self._limits.speed_max_m_s, self._field)
        mode = "crossed" if self._run.crossed else "boundary-seeking"
        return decision(observation, chosen, goal, mode, self._limits.speed_max_m_s)

    def _away_from(self, own: Point, pursuers: list[Point]) -> Point:
        """The direction to the boundary, pushed weakly away from near pursuers."""
        north, east = self._direction
        for place in pursuers:
            nearness = 1.0 - math.dist(own, place) / self._parameters.pursuer_influence_m
            if nearness > 0.0:
                push = towards(place, own)
                north += self._parameters.pursuer_gain * nearness * push[0]
                east += self._parameters.pursuer_gain * nearness * push[1]
        return unit((north, east))

    def _scene(self, observation: Observation, own: Point, movers: list[Mover]) -> Array:
        age_s = max(0.0, observation.t_s - observation.obstacles.t_s)
        inflation_m = self._limits.body_radius_m + self._limits.safety_margin_m
        range_m = self._parameters.obstacle_range_m
        return build_scene(observation.obstacles.discs, age_s, own, inflation_m, range_m, movers, NO_TRAIL, 0.0, 0.0)
