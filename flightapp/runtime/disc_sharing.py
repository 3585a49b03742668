"""Obstacles told between vehicles, as the control loop runs it: the own camera's for the others, theirs for the own planner.

Between pursuers only, and only if the profile says so (`network.share_discs`). The supervisor is never given what was told: a
mate that lies, or tells what is long gone, can lead the planner a longer way or have it wait, but free no way and move no guard.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flightapp.core.types import Array, ObstacleSet, TargetTrack, VehicleState
from flightapp.fleet.messages.discs import DISCS, Discs
from flightapp.fleet.shared_state import SharedState
from flightapp.fleet.sharing.choosing import Presence, Seen, Way, worth_telling
from flightapp.fleet.sharing.heard import HeardDiscs
from flightapp.runtime.perception_thread import Perceived
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.teamwork import ACTIVE_PHASES, CUT_OUT_MARGIN_M, FORGOTTEN_S, Teamwork
from perception.free_space import is_seen_free

PERIOD_S = 1.0
PERCEIVED_AGE_MAX_S = 0.5
"""An older picture is not told."""
PREDICTED_S = 5.0
"""The target's way, and where a mate without a goal will be."""
TARGET_SIGMAS = 3.0


class DiscSharing:
    """Polled once a control period."""

    def __init__(self, rooms: Rooms, teamwork: Teamwork) -> None:
        self._rooms = rooms
        self._teamwork = teamwork
        self._roles = {vehicle.name: vehicle.role for vehicle in rooms.mission.vehicles}
        self._shares = rooms.profile.network.share_discs and rooms.vehicle.role == "pursuer"
        self._heard = HeardDiscs()
        self._due_s = -math.inf
        self._frame: int | None = None
        self._touching_m = rooms.limits.body_radius_m + CUT_OUT_MARGIN_M
        if self._shares:
            self._outlet, self._inlet = rooms.team.post.outlet(DISCS), rooms.team.post.inlet(DISCS)

    def poll(self, now_s: float, own: VehicleState, target: TargetTrack | None, perceived: Perceived | None) -> None:
        """Take what was heard, compare it with the newest picture, tell what is due."""
        if not self._shares:
            return
        for sender, message in self._inlet.take(now_s):
            if self._roles[sender] == "pursuer":
                self._heard.take(sender, message, now_s)
        self._look(now_s, own, perceived)
        if perceived is not None and now_s >= self._due_s and now_s - perceived.frame_s <= PERCEIVED_AGE_MAX_S:
            self._tell(now_s, target, perceived)

    def for_planner(self, now_s: float, own: VehicleState, target: TargetTrack | None, obstacles: ObstacleSet) -> ObstacleSet:
        """`obstacles`, which the own camera sees, and what mates have told of places that it does not see."""
        if not self._shares:
            return obstacles
        near = list(self._presences(now_s, target, is_sure=True))
        return obstacles.with_standing(self._heard.unknown(now_s, _planar(own), obstacles.discs, near))

    def _look(self, now_s: float, own: VehicleState, perceived: Perceived | None) -> None:
        view = None
        if perceived is not None and perceived.frame_number != self._frame:
            self._frame, view = perceived.frame_number, perceived.view
        is_free = None if view is None else lambda north_m, east_m: is_seen_free(view, north_m, east_m)
        self._heard.look(now_s, _planar(own), self._rooms.limits.body_radius_m, is_free)

    def _tell(self, now_s: float, target: TargetTrack | None, perceived: Perceived) -> None:
        seen = Seen(perceived.obstacles.discs, perceived.age_s, perceived.confidence)
        presences = list(self._presences(now_s, target, is_sure=False))
        told = worth_telling(seen, presences, self._ways(target))
        if told:
            self._due_s = now_s + PERIOD_S
            self._outlet.put(Discs(perceived.frame_s, told), now_s)

    def _presences(self, now_s: float, target: TargetTrack | None, *, is_sure: bool) -> Iterator[Presence]:
        """Every other vehicle. is_sure: only where it is, not where else it may be."""
        telling = self._teamwork.evader_state()
        for state in (peer.state for peer in self._rooms.team.peers.values()):
            if state is not None and now_s - state.t_s <= FORGOTTEN_S:
                yield self._presence_of(state, now_s, is_sure=is_sure)
        if target is not None:
            spread_m = TARGET_SIGMAS * math.sqrt(float(np.linalg.eigvalsh(target.covariance[:2, :2])[1]))
            north_m, east_m, _ = target.position_ned_m.tolist()
            yield Presence(north_m, east_m, self._touching_m, self._touching_m, 0.0 if is_sure else self._touching_m + spread_m)
        elif not is_sure and (telling is None or telling.airborne):
            yield Presence(0.0, 0.0, 0.0, self._touching_m, math.inf)  # The target may be anywhere.

    def _presence_of(self, state: SharedState, now_s: float, *, is_sure: bool) -> Presence:
        ahead_s = now_s - state.t_s
        north_m, east_m, _ = (p + v * ahead_s for p, v in zip(state.position_ned_m, state.velocity_ned_m_s, strict=True))
        acceleration = self._rooms.limits.acceleration_max_m_s2
        turned_m = min(0.5 * acceleration * ahead_s**2, 2.0 * self._rooms.limits.speed_max_m_s * ahead_s)
        possible_m = 0.0 if is_sure else self._touching_m + turned_m
        return Presence(north_m, east_m, self._touching_m, self._touching_m, possible_m)

    def _ways(self, target: TargetTrack | None) -> list[Way]:
        """Of mates that take part, to their goals and to the target; with them that of the target itself."""
        predicted = None if target is None else _after(target.position_ned_m[:2], target.velocity_ned_m_s[:2], PREDICTED_S)
        ways = []
        for name, peer in self._rooms.team.peers.items():
            state = peer.state
            if state is None or self._roles[name] != "pursuer" or name in self._teamwork.silent:
                continue
            if not state.airborne or state.phase not in ACTIVE_PHASES:
                continue
            place = state.position_ned_m[0], state.position_ned_m[1]
            goal = state.goal_ned_m
            ends = [] if goal is None else [(goal[0], goal[1])]
            ends += [] if predicted is None else [predicted]
            ends += [] if ends else [_after(np.array(place), np.array(state.velocity_ned_m_s[:2]), PREDICTED_S)]
            ways += [Way(place, end) for end in ends]
        if ways and target is not None and predicted is not None:
            ways.append(Way((float(target.position_ned_m[0]), float(target.position_ned_m[1])), predicted))
        return ways


def _planar(own: VehicleState) -> tuple[float, float]:
    return float(own.position_ned_m[0]), float(own.position_ned_m[1])


def _after(place: Array, velocity: Array, time_s: float) -> tuple[float, float]:
    north_m, east_m = place + velocity * time_s
    return float(north_m), float(east_m)
