"""What of an observation becomes a body: discs that are no vehicles, teammates, and what is remembered of each body."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.adaptive_apf.field import TRACK_COLUMNS
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.space.bodies import BODY_COLUMNS, BOTTOM, CYLINDER, EAST, LENGTH, NORTH, TOP, V_EAST, V_NORTH
from flightapp.space.shapes import bodies_of_discs

Mask = NDArray[np.bool_]
SAME_BODY_M = 0.5
"""A body this near to where one was is that one."""


class Surroundings:
    """The bodies around, row by row, with their tracks; `heights_known`: of every disc."""

    def __init__(self, parameters: AdaptiveApfParameters, limits: Limits) -> None:
        self._parameters, self._limits = parameters, limits
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.bodies = np.zeros((0, BODY_COLUMNS))
        self.tracks = np.zeros((0, TRACK_COLUMNS))
        self.heights_known = True
        self.dropped = 0

    def look(self, observation: Observation, target: Array | None) -> None:
        """Take over what is seen now; `target` (3,) is where the target is, whose own disc is no obstacle."""
        discs = observation.obstacles.discs
        usable = np.isfinite(discs[:, :5]).all(axis=1) & (discs[:, 2] >= 0.0) & ~np.isnan(discs).any(axis=1)
        self.dropped = len(discs) - int(usable.sum())
        bodies = bodies_of_discs(discs[usable])
        passed_s = min(max(0.0, observation.t_s - observation.obstacles.t_s), self._parameters.prediction_max_s)
        bodies[:, (NORTH, EAST)] += passed_s * bodies[:, (V_NORTH, V_EAST)]
        bodies[:, (TOP, BOTTOM)] = np.sort(bodies[:, (TOP, BOTTOM)], axis=1)
        mates = self._mates(observation)
        others = mates[:, (NORTH, EAST)]
        if target is not None:
            others = np.concatenate((others, target[None, :2]))
        bodies = bodies[~self._are_vehicles(bodies, others)]
        self.heights_known = bool(np.isfinite(bodies[:, (TOP, BOTTOM)]).any(axis=1).all())
        self._take_over(np.ascontiguousarray(np.concatenate((bodies, mates))))

    def _mates(self, observation: Observation) -> Array:
        """Teammates as upright cylinders of any height: nobody flies over or under another."""
        rows = np.zeros((len(observation.team), BODY_COLUMNS))
        count = 0
        for member in observation.team:
            n, e, _ = member.state.position_ned_m.tolist()
            vn, ve, _ = member.state.velocity_ned_m_s.tolist()
            if not math.isfinite(n + e + vn + ve):
                continue
            ahead_s = min(max(0.0, observation.t_s - member.state.t_s), self._parameters.prediction_max_s)
            age_s = min(max(0.0, member.age_s), self._parameters.team_stale_s)
            grown = self._limits.body_radius_m + 0.5 * self._limits.acceleration_max_m_s2 * age_s * age_s
            rows[count] = CYLINDER, n + ahead_s * vn, e + ahead_s * ve, grown, 0.0, -math.inf, math.inf, 1.0, 0.0, vn, ve, 0.0
            count += 1
        return rows[:count]

    def _are_vehicles(self, bodies: Array, others: Array) -> Mask:
        if not len(others) or self._parameters.vehicle_radius_max_m == 0.0:
            return np.zeros(len(bodies), dtype=np.bool_)
        apart = np.hypot(bodies[:, None, NORTH] - others[None, :, 0], bodies[:, None, EAST] - others[None, :, 1])
        near = (apart - bodies[:, None, LENGTH] <= self._parameters.vehicle_disc_m).any(axis=1)
        small: Mask = near & (bodies[:, LENGTH] <= self._parameters.vehicle_radius_max_m)
        return small

    def _take_over(self, bodies: Array) -> None:
        """Rows have no names: the nearest old body hands its track on."""
        tracks = np.zeros((len(bodies), TRACK_COLUMNS))
        if len(self.bodies) and len(bodies):
            apart = np.hypot(
                bodies[:, None, NORTH] - self.bodies[None, :, NORTH], bodies[:, None, EAST] - self.bodies[None, :, EAST]
            )
            nearest = apart.argmin(axis=1)
            same = apart[np.arange(len(bodies)), nearest] <= SAME_BODY_M
            tracks[same] = self.tracks[nearest[same]]
        self.bodies, self.tracks = bodies, tracks
