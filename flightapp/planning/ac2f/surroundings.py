"""The other vehicles as one planner sees them: where they are now, and where they just were."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, Observation, TargetTrack, TeamMember
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
    """Places of the evader and the teammates over the last seconds, to tell sightings of them from obstacles."""

    def __init__(self, duration_s: float, period_s: float) -> None:
        self._duration_s = duration_s
        self._period_s = period_s
        self._next_s = -np.inf
        self._places: list[tuple[float, Point]] = []

    def update(self, observation: Observation) -> None:
        t_s = observation.t_s
        if t_s < self._next_s - 1e-9:
            return
        self._next_s = t_s + self._period_s
        self._places = [(since, place) for since, place in self._places if t_s - since <= self._duration_s]
        self._places.extend((t_s, place) for place in _others(observation))

    def places(self, observation: Observation) -> Array:
        """(k, 2) m: the trail and the present places."""
        points = [place for _, place in self._places]
        points.extend(_others(observation))
        return np.array(points, dtype=np.float64).reshape(-1, 2)


def _others(observation: Observation) -> list[Point]:
    places = [teammate_now(member)[0] for member in observation.team]
    if observation.target is not None:
        places.append(target_now(observation.target, observation.t_s).position)
    return places


def _moved(position: Point, velocity: Point, time_s: float) -> Point:
    return position[0] + velocity[0] * time_s, position[1] + velocity[1] * time_s
