"""Evader policy `voronoi-centroid`: to the centroid of its Voronoi cell among the pursuers, drawn towards the boundary."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.boundary_run import BoundaryRun
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import VoronoiCentroidParameters
from flightapp.planning.evasion.pursuers import pursuer_rows
from flightapp.planning.evasion.voronoi_cell import cell_centroid
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, limited, planar


class VoronoiCentroid:
    """Stays where the pursuers are not, and comes nearer to the boundary where that is free. Beyond it it stands."""

    def __init__(self, *, limits: Limits, parameters: VoronoiCentroidParameters) -> None:
        self._speed_max_m_s = limits.speed_max_m_s
        self._inflation_m = limits.body_radius_m + limits.safety_margin_m
        self._parameters = parameters
        self._avoidance = Avoidance(limits, parameters)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget the crossing."""
        del seed
        self._run = BoundaryRun()

    def step(self, observation: Observation) -> Decision:
        own = planar(observation.own.position_ned_m)
        nearest = self._run.goal(observation)
        pursuers = pursuer_rows(observation)
        centroid = self._centroid(observation, own, pursuers)
        wish = (0.0, 0.0) if self._run.crossed else self._wish(own, centroid, self._run.direction(own, nearest))
        velocity = self._avoidance.velocity(observation, own, pursuers, wish)
        mode = "crossed" if self._run.crossed else "voronoi-centroid"
        return decision(observation, velocity, centroid, mode, self._speed_max_m_s)

    def _centroid(self, observation: Observation, own: Point, pursuers: Array) -> Point:
        """The own cell's centroid (m); the own position where the cell is empty."""
        parameters = self._parameters
        reach = parameters.reach_m
        area = parameters.area_m or (own[0] - reach, own[1] - reach, own[0] + reach, own[1] + reach)
        discs = np.ascontiguousarray(observation.obstacles.discs, dtype=np.float64)
        north, east, size_m2 = cell_centroid(*own, pursuers, discs, self._inflation_m, parameters.obstacle_range_m, *area)
        return (north, east) if size_m2 > 0.0 else own

    def _wish(self, own: Point, centroid: Point, to_boundary: Point) -> Point:
        """Full speed to both attractors together; slower only where they cancel, or at the centroid without a bias."""
        bias = self._parameters.boundary_bias
        near_m = self._speed_max_m_s * self._parameters.settling_s
        pull = limited(((centroid[0] - own[0]) / near_m, (centroid[1] - own[1]) / near_m), 1.0)
        north, east = pull[0] + bias * to_boundary[0], pull[1] + bias * to_boundary[1]
        full = self._speed_max_m_s / (bias if bias > 0.0 else 1.0)
        speed = min(self._speed_max_m_s, full * math.hypot(north, east))
        direction = math.atan2(east, north)
        return speed * math.cos(direction), speed * math.sin(direction)


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return VoronoiCentroid(limits=limits, parameters=parsed(VoronoiCentroidParameters, name, given))
