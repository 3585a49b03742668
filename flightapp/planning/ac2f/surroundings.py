"""The other vehicles as one planner sees them: where they are now, and where they just were."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, TargetTrack, TeamMember
from flightapp.planning.plane import Point, planar

PREDICTION_MAX_S = 1.0


@dataclass(frozen=True, slots=True)
class Target:
    """The evader now: predicted position (m), velocity (m/s), and age of its last measurement (s)."""

    position: Point
    velocity: Point
    age_s: float


def target_now(track: TargetTrack, t_s: float) -> Target:
    """`track` predicted to `t_s`."""
    ahead_s = min(PREDICTION_MAX_S, max(0.0, t_s - track.t_s))
    position, velocity = planar(track.position_ned_m), planar(track.velocity_ned_m_s)
    return Target(_moved(position, velocity, ahead_s), velocity, track.age_s)


def teammate_now(member: TeamMember) -> tuple[Point, Point]:
    """Position (m) and velocity (m/s) of a teammate, predicted over the age of its state."""
    velocity = planar(member.state.velocity_ned_m_s)
    return _moved(planar(member.state.position_ned_m), velocity, min(PREDICTION_MAX_S, max(0.0, member.age_s))), velocity


class Trail:
    """Rows north, east (m) of where the others were in the last `duration_s`, one sample every `period_s`."""

    def __init__(self, duration_s: float, period_s: float) -> None:
        self._duration_s = duration_s
        self._period_s = period_s
        self._next_s = -math.inf
        self._since_s: list[float] = []
        self._rows = np.zeros((64, 2))

    def places(self, t_s: float, present: Sequence[Point]) -> Array:
        """(k, 2) m, valid until the next call: the trail and the places `present` at `t_s`, which join it when one is due."""
        if t_s >= self._next_s - 1e-9:
            self._next_s = t_s + self._period_s
            self._forget(t_s)
            self._write(present)
            self._since_s.extend([t_s] * len(present))
        self._write(present)
        return self._rows[: len(self._since_s) + len(present)]

    def _forget(self, t_s: float) -> None:
        count = len(self._since_s)
        old = sum(t_s - since > self._duration_s for since in self._since_s)
        if old:
            self._rows[: count - old] = self._rows[old:count]
            del self._since_s[:old]

    def _write(self, present: Sequence[Point]) -> None:
        """Put `present` behind the trail."""
        end = len(self._since_s) + len(present)
        if end > len(self._rows):
            self._rows = np.concatenate((self._rows, np.zeros((end, 2))))
        for row, place in enumerate(present, len(self._since_s)):
            self._rows[row] = place


def _moved(position: Point, velocity: Point, time_s: float) -> Point:
    return position[0] + velocity[0] * time_s, position[1] + velocity[1] * time_s
