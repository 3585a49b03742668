"""Flies a trajectory by velocity setpoints: where it is to be, how fast, and patience when something holds the vehicle up."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Limits, Setpoint, VehicleState
from flightapp.planning.path_planning.trajectory import Trajectory

POSITION_GAIN_1_S = 0.8
LEAD_S = 0.3
"""By how much the velocity is asked for early: the autopilot's velocity loop lags by about that."""
LATE_M, STOPPED_M = 1.0, 3.0
"""From the first distance on the trajectory waits for the vehicle; at the second it stands."""
ARRIVED_M = 1.0
YAW_SPEED_MIN_M_S = 0.5
STALLED_S = 8.0
TIME_SHARE, TIME_MORE_S = 2.0, 20.0
"""A way may take this many times what it was planned to take, and so much more: who creeps along it is held up as well."""


class WayFollower:
    """Time on the trajectory goes on only as far as the vehicle follows: a guard that brakes it is not run away from."""

    def __init__(self, trajectory: Trajectory, limits: Limits, *, feed_forward: bool) -> None:
        self._trajectory = trajectory
        self._limits = limits
        self._feed_forward = feed_forward
        self._on_way_s = 0.0
        self._asked_s: float | None = None
        self._progress_s: float | None = None
        self._progress_on_way_s = 0.0
        self._flown_s = 0.0
        self.arrived = False
        self.failure = ""
        """Why the vehicle does not get there, once that is so."""

    @property
    def time_limit_s(self) -> float:
        """How long the vehicle may be on its way, pauses not counted."""
        return TIME_SHARE * self._trajectory.duration_s + TIME_MORE_S

    def pause(self) -> None:
        """Somebody holds the vehicle: until the next setpoint neither patience nor the time limit run."""
        self._asked_s = self._progress_s = None

    def setpoint(self, own: VehicleState, now_s: float, yaw_rad: float) -> Setpoint:
        """The next velocity, never faster than the limits; `yaw_rad` is kept where there is no direction."""
        late_m = math.dist(own.position_ned_m, self._trajectory.at(self._on_way_s).position_ned_m)
        self._advance(now_s, late_m)
        moment, ahead = self._trajectory.at(self._on_way_s), self._trajectory.at(self._on_way_s + LEAD_S)
        pace = _pace(late_m)
        velocity = pace * ahead.velocity_ned_m_s + POSITION_GAIN_1_S * (moment.position_ned_m - own.position_ned_m)
        planar = math.hypot(velocity[0], velocity[1])
        if planar > self._limits.speed_max_m_s:
            velocity[:2] *= self._limits.speed_max_m_s / planar
        velocity[2] = np.clip(velocity[2], -self._limits.climb_rate_max_m_s, self._limits.sink_rate_max_m_s)
        if planar > YAW_SPEED_MIN_M_S:
            yaw_rad = math.atan2(velocity[1], velocity[0])
        ended = self._on_way_s >= self._trajectory.duration_s
        self.arrived = ended and math.dist(own.position_ned_m, moment.position_ned_m) < ARRIVED_M
        return Setpoint(velocity, yaw_rad, ahead.acceleration_ned_m_s2 if self._feed_forward and pace == 1.0 else None)

    def _advance(self, now_s: float, late_m: float) -> None:
        passed_s = 0.0 if self._asked_s is None else max(0.0, now_s - self._asked_s)
        self._asked_s = now_s
        self._flown_s += passed_s
        self._on_way_s = min(self._trajectory.duration_s, self._on_way_s + passed_s * _pace(late_m))
        moved = self._trajectory.duration_s > self._on_way_s > self._progress_on_way_s + 0.1
        if self._progress_s is None or moved:
            self._progress_s, self._progress_on_way_s = now_s, self._on_way_s
        if now_s - self._progress_s > STALLED_S:
            self.failure = f"no progress for {STALLED_S:g} s"
        elif self._flown_s > self.time_limit_s:
            self.failure = f"not there after {self.time_limit_s:.0f} s, planned in {self._trajectory.duration_s:.0f} s"


def _pace(late_m: float) -> float:
    """How fast time on the trajectory goes, in [0, 1]."""
    return min(1.0, max(0.0, (STOPPED_M - late_m) / (STOPPED_M - LATE_M)))
