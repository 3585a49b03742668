"""Evader policy `recorded`: flies a recorded track, from where it stands and towards the boundary."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.errors import InputError
from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.boundary_run import BoundaryRun
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import RecordedParameters
from flightapp.planning.evasion.track import Track
from flightapp.planning.evasion.track_file import read_track
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, planar


class Recorded:
    """Follows a point that moves along the track; it moves slower where the vehicle's limit or its lag asks for it."""

    def __init__(self, *, limits: Limits, parameters: RecordedParameters) -> None:
        self._speed_max_m_s = limits.speed_max_m_s
        self._parameters = parameters
        rows = read_track(parameters.file)
        if parameters.start_s >= rows[-1, 0]:
            raise InputError(
                f"strategy 'recorded': start_s = {parameters.start_s}: {parameters.file} ends after {rows[-1, 0]:g} s"
            )
        self._track = Track(rows[np.searchsorted(rows[:, 0], parameters.start_s, side="right") - 1 :])
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Start the track again, from wherever the vehicle is then."""
        del seed
        self._run = BoundaryRun()
        self._before_s: float | None = None
        self._origin: Point = (0.0, 0.0)
        self._cos, self._sin = 1.0, 0.0
        self._time_s = 0.0

    def step(self, observation: Observation) -> Decision:
        own = planar(observation.own.position_ned_m)
        nearest = self._run.goal(observation)
        if self._before_s is None:
            self._lay_out(own, nearest)
        else:
            self._advance(own, max(0.0, observation.t_s - self._before_s))
        self._before_s = observation.t_s
        place, velocity = self._now()
        scale = self._speed_scale(velocity)
        gain = self._parameters.position_gain_1_s
        wish = (scale * velocity[0] + gain * (place[0] - own[0]), scale * velocity[1] + gain * (place[1] - own[1]))
        return decision(observation, wish, place, "crossed" if self._run.crossed else "recorded", self._speed_max_m_s)

    def _lay_out(self, own: Point, goal: Point) -> None:
        """Put the track at `own`, turned so that it leads to `goal`."""
        self._origin = own
        towards_rad = math.atan2(goal[1] - own[1], goal[0] - own[0])
        turn_rad = towards_rad - self._track.bearing_rad() + math.radians(self._parameters.rotation_deg)
        self._cos, self._sin = math.cos(turn_rad), math.sin(turn_rad)

    def _advance(self, own: Point, dt_s: float) -> None:
        place, velocity = self._now()
        if math.dist(own, place) <= self._parameters.lead_max_m:
            self._time_s += dt_s * self._speed_scale(velocity)
        if self._parameters.loop and self._time_s >= self._track.duration_s:
            self._origin = self._in_mission(self._track.at(self._track.duration_s)[0], self._origin)
            self._time_s -= self._track.duration_s

    def _speed_scale(self, velocity: Point) -> float:
        """Flown over recorded speed where the recorded velocity is `velocity`."""
        recorded = math.hypot(*velocity)
        limit = self._speed_max_m_s / recorded if recorded > 0.0 else math.inf
        return min(self._parameters.speed_scale, limit)

    def _now(self) -> tuple[Point, Point]:
        """Place (m) in the mission frame and recorded velocity (m/s) of the moving point."""
        place, velocity = self._track.at(self._time_s)
        return self._in_mission(place, self._origin), self._in_mission(velocity, (0.0, 0.0))

    def _in_mission(self, vector: Point, origin: Point) -> Point:
        north, east = vector
        return origin[0] + self._cos * north - self._sin * east, origin[1] + self._sin * north + self._cos * east


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Recorded(limits=limits, parameters=parsed(RecordedParameters, name, given))
