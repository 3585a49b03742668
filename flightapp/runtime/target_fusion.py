"""One estimate of the evader from all that is told and seen of it: its own telemetry, the own camera's and the others' sightings.

Sightings come from where the evader should be. What its telemetry places is left out of the obstacles, and the camera's view of
that very place is a sighting. Where telemetry has ended, the track itself says where to look, as long as it is sharp; beyond
that only one single thing that is proven to move, near enough, is taken for the evader. When in doubt there is no sighting.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.config.mission import TargetKnowledge
from flightapp.core.types import Array, TargetTrack
from flightapp.estimation.measurement import Measurement, seen, told
from flightapp.estimation.refiltering import GATES_SEEN
from flightapp.estimation.sighting_noise import sighting_sigma_m
from flightapp.fleet.messages.sighting import SIGHTING, Sighting, as_heard
from flightapp.fleet.shared_state import SharedState
from flightapp.runtime.perception_thread import Perceived
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.teamwork import CUT_OUT_MARGIN_M, Teamwork

TOLD_POSITION_SIGMA_M = 0.1
TOLD_VELOCITY_SIGMA_M_S = 0.2
SIGHTING_PERIOD_S = 0.1
SIGHTINGS_WAITING = 4
PERIOD_TOLERANCE = 0.95
"""Frames do not come to the millisecond."""
CUT_OUT_SPREAD_MAX_M = 0.6
"""A track that is less sharp leaves nothing out of the obstacles: the circle would hide more than the evader."""
MOVING_MIN_M_S = 0.5
SURFACE_TO_MIDDLE = 0.785
"""Of the body radius: mean depth of the visible half of a ball."""
NOTHING = (math.nan, math.nan, math.nan)
"""In place of the evader's circle."""
BEFORE_PURSUIT = ("preflight", "arm", "takeoff", "ready")


class TargetFusion:
    """Owns what goes into `rooms.target_filter`, on every vehicle but the evader."""

    def __init__(self, rooms: Rooms, teamwork: Teamwork) -> None:
        self._rooms = rooms
        self._teamwork = teamwork
        self._knowledge: TargetKnowledge = rooms.mission.target
        self._is_pursuer = rooms.vehicle.role != "evader"
        self._outlet = rooms.team.post.outlet(SIGHTING)
        self._inlet = rooms.team.post.inlet(SIGHTING, depth=SIGHTINGS_WAITING)
        self._told: SharedState | None = None
        self._told_s = -math.inf
        self._frame: int | None = None
        self._sighted_s = -math.inf
        self._track: TargetTrack | None = None

    def update(self, now_s: float, phase: str, perceived: Perceived | None) -> TargetTrack | None:
        """Take in what came since the last call; the track at `now_s`, None where nothing is known."""
        if not self._is_pursuer:
            return None
        if self._knowledge.telemetry == "always" or phase in BEFORE_PURSUIT:
            self._take_telemetry(now_s)
        self._take_sightings(now_s, perceived)
        self._track = self._rooms.target_filter.predict(now_s)
        if self._track is not None:
            self._rooms.journal.target(self._track, now_s)
        return self._track

    def cut_outs(self, now_s: float) -> Array:
        """Rows north_m, east_m, radius_m that must not become obstacles: first the evader's, of nan where it has none."""
        others = self._teamwork.cut_outs(now_s)
        return np.vstack((np.array([self._cut_out(now_s)]), others))

    def _take_telemetry(self, now_s: float) -> None:
        state = self._teamwork.evader_state()
        if state is None or state is self._told:
            return
        self._told, self._told_s = state, state.t_s
        position, velocity = state.position_ned_m, state.velocity_ned_m_s
        measurement = told(state.t_s, position, velocity, TOLD_POSITION_SIGMA_M, TOLD_VELOCITY_SIGMA_M_S)
        self._take(measurement, "telemetry", state.vehicle, position[:2], TOLD_POSITION_SIGMA_M, now_s)

    def _take_sightings(self, now_s: float, perceived: Perceived | None) -> None:
        heard = self._inlet.take(now_s)
        if self._knowledge.when_silent == "lost" and self._is_silent(now_s):
            return
        own = self._own_sighting(now_s, perceived)
        if own is not None:
            self._outlet.put(own, now_s)
            heard.append((self._rooms.vehicle.name, as_heard(own, now_s)))
        for vehicle, told_of in heard:
            place = told_of.north_m, told_of.east_m
            measurement = seen(told_of.t_s, *place, told_of.bearing_rad, told_of.range_sigma_m, told_of.across_sigma_m)
            self._take(measurement, "camera", vehicle, place, told_of.range_sigma_m, now_s)

    def _take(
        self,
        measurement: Measurement | None,
        source: str,
        vehicle: str,
        place: tuple[float, float],
        sigma_m: float,
        now_s: float,
    ) -> None:
        fit = None if measurement is None else self._rooms.target_filter.take(measurement)
        if measurement is not None and fit is not None:
            self._rooms.journal.sighting(measurement.t_s, source, vehicle, place, sigma_m, fit, now_s)

    def _own_sighting(self, now_s: float, perceived: Perceived | None) -> Sighting | None:
        """What the newest frame shows of the evader, at most every SIGHTING_PERIOD_S."""
        if perceived is None or perceived.frame_number == self._frame:
            return None
        self._frame = perceived.frame_number
        if perceived.frame_s - self._sighted_s < PERIOD_TOLERANCE * SIGHTING_PERIOD_S:
            return None
        body_m = self._rooms.limits.body_radius_m
        if len(perceived.left_out) and math.isfinite(perceived.left_out[0, 0]):
            place = _pushed_back(perceived.left_out[0], perceived.seen_from_m, SURFACE_TO_MIDDLE * body_m)
            sighting: Sighting | None = _sighting(perceived.frame_s, place, perceived.seen_from_m, 0.0)
        elif self._is_silent(now_s):
            sighting = self._moving_thing(perceived, body_m)
        else:
            sighting = None
        if sighting is not None:
            self._sighted_s = perceived.frame_s
        return sighting

    def _moving_thing(self, perceived: Perceived, body_m: float) -> Sighting | None:
        """The only thing seen in this frame that moves, is small enough, and is where the evader may be."""
        track = self._rooms.target_filter.predict(perceived.frame_s)
        discs = perceived.obstacles.discs
        if track is None or not len(discs):
            return None
        may_be = (perceived.age_s == 0.0) & (discs[:, 2] <= body_m + CUT_OUT_MARGIN_M)
        may_be &= np.hypot(discs[:, 3], discs[:, 4]) >= MOVING_MIN_M_S
        near = []
        for disc in discs[may_be]:
            sighting = _sighting(perceived.frame_s, (float(disc[0]), float(disc[1])), perceived.seen_from_m, 0.5 * body_m)
            offset = disc[:2] - track.position_ned_m[:2]
            spread = track.covariance[:2, :2] + sighting.range_sigma_m**2 * np.eye(2)
            if float(offset @ np.linalg.solve(spread, offset)) <= GATES_SEEN[2]:
                near.append(sighting)
        return near[0] if len(near) == 1 else None

    def _is_silent(self, now_s: float) -> bool:
        return now_s - self._told_s > self._rooms.profile.safety.team_state_age_max_s

    def _cut_out(self, now_s: float) -> tuple[float, float, float]:
        radius_m = self._rooms.limits.body_radius_m + CUT_OUT_MARGIN_M
        state = self._teamwork.evader_state()
        if state is not None and not self._is_silent(now_s):
            if not state.airborne:
                return NOTHING
            ahead_s = now_s - state.t_s
            north, east, _ = (p + v * ahead_s for p, v in zip(state.position_ned_m, state.velocity_ned_m_s, strict=True))
            return north, east, radius_m
        track = self._track
        if track is None or not self._is_pursuer:
            return NOTHING
        spread_m = math.sqrt(float(np.linalg.eigvalsh(track.covariance[:2, :2])[1]))
        if spread_m > CUT_OUT_SPREAD_MAX_M or self._knowledge.when_silent == "lost":
            return NOTHING
        return float(track.position_ned_m[0]), float(track.position_ned_m[1]), radius_m


def _pushed_back(surface: Array, seen_from_m: tuple[float, float], by_m: float) -> tuple[float, float]:
    """The place `by_m` behind `surface` (2,) on the line of sight."""
    north, east = float(surface[0]), float(surface[1])
    distance = max(math.hypot(north - seen_from_m[0], east - seen_from_m[1]), 1e-6)
    return north + (north - seen_from_m[0]) / distance * by_m, east + (east - seen_from_m[1]) / distance * by_m


def _sighting(t_s: float, place: tuple[float, float], seen_from_m: tuple[float, float], more_sigma_m: float) -> Sighting:
    north, east = place[0] - seen_from_m[0], place[1] - seen_from_m[1]
    along_m, across_m = sighting_sigma_m(math.hypot(north, east))
    return Sighting(t_s, *place, math.atan2(east, north), along_m + more_sigma_m, across_m + more_sigma_m)
