"""What of an observation becomes a body: discs that are no vehicles, teammates, and what is remembered of each body."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.adaptive_apf.field import KNOWN, TRACK_COLUMNS
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.space.bodies import BODY_COLUMNS, BOTTOM, CYLINDER, EAST, LENGTH, NORTH, TOP, V_EAST, V_NORTH
from flightapp.space.shapes import bodies_of_discs

Mask = NDArray[np.bool_]
SAME_BODY_M = 0.5
"""A body this near to where one was is that one."""
STANDING_M_S = 0.3
TURN_M_S2 = 2.0
"""Of a body that moves, unseen: what it may change its course by."""
UNSEEN_MAX_S = 3.0
"""What was seen last, where a row of the obstacles is not usable, counts this long."""
UNKNOWN = np.array((0.0, 0.0, 0.0, 0.0, 0.0, -math.inf, math.inf))
"""In the place of what a row does not say: it stands, and has no end above or below."""


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
        self._good = np.zeros((0, BODY_COLUMNS))
        self._good_s = np.zeros(0)

    def forget_reaches(self) -> None:
        """The activation distances begin anew: too long ago was the last look. The sides of passing are kept."""
        self.tracks[:, KNOWN] = 0.0

    def look(self, observation: Observation, target: Array | None) -> None:
        """Take over what is seen now; `target` (3,) is where the target is, whose own disc is no obstacle."""
        discs = observation.obstacles.discs
        usable = np.isfinite(discs[:, :3]).all(axis=1) & (discs[:, 2] >= 0.0)
        self.dropped = len(discs) - int(usable.sum())
        bodies = bodies_of_discs(np.where(np.isnan(discs[usable]), UNKNOWN, discs[usable]))
        bodies[:, (V_NORTH, V_EAST)] = np.where(np.isfinite(bodies[:, (V_NORTH, V_EAST)]), bodies[:, (V_NORTH, V_EAST)], 0.0)
        bodies[:, (TOP, BOTTOM)] = np.sort(bodies[:, (TOP, BOTTOM)], axis=1)
        age_s = max(0.0, observation.t_s - observation.obstacles.t_s)
        bodies = self._with_unseen(bodies, observation.own.position_ned_m, observation.t_s - age_s)
        passed_s = min(age_s, self._parameters.prediction_max_s)
        bodies[:, (NORTH, EAST)] += passed_s * bodies[:, (V_NORTH, V_EAST)]
        grow(bodies, age_s - passed_s)
        mates = self._mates(observation)
        others = mates[:, (NORTH, EAST)]
        if target is not None:
            others = np.concatenate((others, target[None, :2]))
        bodies = bodies[~self._are_vehicles(bodies, others)]
        self.heights_known = bool(np.isfinite(bodies[:, (TOP, BOTTOM)]).any(axis=1).all())
        self._take_over(np.ascontiguousarray(np.concatenate((bodies, mates))))

    def _with_unseen(self, bodies: Array, own: Array, t_s: float) -> Array:
        """`bodies`, seen at `t_s`, and for each row that was not usable the nearest body that is missing, as last seen, grown."""
        good, good_s = bodies, np.full(len(bodies), t_s)
        if self.dropped and len(self._good):
            moved = self._good[:, (NORTH, EAST)] + (t_s - self._good_s)[:, None] * self._good[:, (V_NORTH, V_EAST)]
            nearest_m = _apart(moved, bodies[:, (NORTH, EAST)]).min(axis=1, initial=math.inf)
            missing = (nearest_m > SAME_BODY_M) & (t_s - self._good_s <= UNSEEN_MAX_S)
            far = np.where(missing, np.hypot(moved[:, 0] - own[0], moved[:, 1] - own[1]), math.inf)
            chosen = np.argsort(far, kind="stable")[: min(self.dropped, int(missing.sum()))]
            unseen = self._good[chosen].copy()
            for row, seen_s in zip(unseen, self._good_s[chosen], strict=True):
                grow(row[None], t_s - seen_s)
            good = np.concatenate((bodies, self._good[chosen]))
            good_s = np.concatenate((good_s, self._good_s[chosen]))
            bodies = np.concatenate((bodies, unseen))
        self._good, self._good_s = good.copy(), good_s
        return bodies

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
        apart = _apart(bodies[:, (NORTH, EAST)], others)
        near = (apart - bodies[:, None, LENGTH] <= self._parameters.vehicle_disc_m).any(axis=1)
        small: Mask = near & (bodies[:, LENGTH] <= self._parameters.vehicle_radius_max_m)
        return small

    def _take_over(self, bodies: Array) -> None:
        """Rows have no names: the nearest old body hands its track on."""
        tracks = np.zeros((len(bodies), TRACK_COLUMNS))
        if len(self.bodies) and len(bodies):
            apart = _apart(bodies[:, (NORTH, EAST)], self.bodies[:, (NORTH, EAST)])
            nearest = apart.argmin(axis=1)
            same = apart[np.arange(len(bodies)), nearest] <= SAME_BODY_M
            tracks[same] = self.tracks[nearest[same]]
        self.bodies, self.tracks = bodies, tracks


def grow(bodies: Array, age_s: float) -> None:
    """Make the `bodies` that move as large as the place where they can be `age_s` after they were seen."""
    speeds = np.hypot(bodies[:, V_NORTH], bodies[:, V_EAST])
    bodies[:, LENGTH] += np.where(speeds > STANDING_M_S, speeds * age_s + 0.5 * TURN_M_S2 * age_s * age_s, 0.0)


def _apart(places: Array, others: Array) -> Array:
    """Distances (n, m) between `places` (n, 2) and `others` (m, 2)."""
    return np.hypot(places[:, None, 0] - others[None, :, 0], places[:, None, 1] - others[None, :, 1])
