"""AC2F in three dimensions: the planar pursuit past what is in the way at this height, and the way up or down to the evader.

The plane's mode is the planar planner itself, so that its results stay what they are, bit for bit. The game about the boundary
is played in space beside the planar one (see `game`): it says at which height the evader is best off, and whether the wall can be
held at all. Far away the height of the game point is flown to, near the evader's own, in between a blend, as in the plane.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flightapp.core.clearance import closest_approach_m
from flightapp.core.types import Array, Decision, Limits, Observation, ObstacleSet, TargetTrack, VehicleState
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.ac2f.candidates import Candidates
from flightapp.planning.ac2f.edge import NO_EDGE, Edge
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.planning.ac2f.volume.clearance import SAME_M, HeightMemory, VerticalRoom, stopping_m, vertical_room
from flightapp.planning.ac2f.volume.game import SpaceGame, solve
from flightapp.planning.ac2f.volume.intercept import meeting_time_s, vertical_interval_s
from flightapp.planning.capture import dwell_since_s, has_dwelt

LEVEL_SHARE = 0.5
"""Of the capture radius: a difference of height below this does not slow the planar approach down."""


class VolumePlanner:
    """The planar planner `planar` with height. Nothing in it is random."""

    def __init__(self, planar: Ac2fPlanner, limits: Limits, parameters: Ac2fParameters) -> None:
        self._planar, self._limits, self._parameters = planar, limits, parameters
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget everything."""
        self._planar.reset(seed)
        self._memory = HeightMemory(self._parameters.volume.memory_s)
        self._down_m_s: float | None = None
        self._offset_m: Array | None = None
        self._edge = NO_EDGE
        self._dwell_since_s = math.nan

    def step(self, observation: Observation) -> Decision:
        """One decision; `flies_height` says that its vertical velocity is all of it."""
        discs = self._memory.with_remembered(observation.obstacles)
        room = self._room(observation, discs)
        self._planar.forget_discs(discs[~room.blocking, :2], SAME_M)
        obstacles = ObstacleSet(observation.obstacles.t_s, discs[room.blocking], observation.obstacles.unseen)
        decision = self._planar.step(replace(observation, obstacles=obstacles))
        target = _present(observation, self._parameters)
        game = None if target is None else self._game(observation, target)
        velocity = decision.velocity_ned_m_s.copy()
        velocity[2] = self._down_velocity_m_s(observation, target, game, room)
        meeting_s = None if target is None else self._meeting_s(observation, target)
        share = 1.0 if target is None else self._planar_share(observation, target, velocity)
        if share < 1.0:
            velocity[:2] *= share
            self._planar.flown((float(velocity[0]), float(velocity[1])))
        goal = decision.goal_ned_m
        if goal is not None:
            goal = np.array((goal[0], goal[1], self._aim_down_m(observation, target, game)))
        captured = self._is_captured(observation, target, decision)
        diagnostics = {**decision.diagnostics, "captured": captured, "passed_discs": int((~room.blocking).sum())}
        diagnostics["meeting_s"] = None if meeting_s is None or math.isnan(meeting_s) else meeting_s
        if game is not None:
            diagnostics["game_height_m"] = -game.point_ned_m[2]
            diagnostics["contested"] = diagnostics["contested"] is True and game.contested
        return replace(decision, velocity_ned_m_s=velocity, goal_ned_m=goal, diagnostics=diagnostics, flies_height=True)

    def candidates(self) -> Candidates | None:
        """As the planar planner's, for the recording."""
        return self._planar.candidates()

    def _room(self, observation: Observation, discs: Array) -> VerticalRoom:
        """What blocks, and how fast the vehicle may climb and sink."""
        own, p, limits = observation.own, self._parameters, self._limits
        n, e, down = own.position_ned_m.tolist()
        speed = math.hypot(own.velocity_ned_m_s[0], own.velocity_ned_m_s[1])
        reaction_s = p.reaction_s + observation.dt_s
        near_m = stopping_m(speed, limits.acceleration_max_m_s2 * p.braking_share, reaction_s)
        near_m += max(p.rejection_radius_m, limits.body_radius_m + limits.safety_margin_m)
        offsets = np.hypot(discs[:, 0] - n, discs[:, 1] - e) - discs[:, 2]
        return vertical_room(discs, offsets, down, float(own.velocity_ned_m_s[2]), near_m, p.volume)

    def _game(self, observation: Observation, target: TargetTrack) -> SpaceGame | None:
        """The game in space of this pursuer, the first, and of teammates whose state is fresh; None where none is played."""
        p, limits = self._parameters, self._limits
        if p.game != "intersection" or len(observation.boundary.vertices_m) < 2:
            return None
        if self._edge.boundary is not observation.boundary:
            self._edge = Edge.of(observation.boundary)
        fresh = [one.state for one in observation.team if one.age_s <= p.team_stale_s]
        places = [observation.own.position_ned_m, *(_moved(one, observation.t_s, p.prediction_max_s) for one in fresh)]
        evader = target.position_ned_m.tolist()
        speed = max(p.evader_speed_assumed_m_s, math.hypot(target.velocity_ned_m_s[0], target.velocity_ned_m_s[1]))
        rates = [limits.climb_rate_max_m_s if place[2] > evader[2] else limits.sink_rate_max_m_s for place in places]
        return solve(
            np.array(places),
            evader,
            [limits.speed_max_m_s / speed] * len(places),
            [limits.speed_max_m_s / rate for rate in rates],
            self._edge.rows,
            (-p.volume.height_max_m, -p.volume.height_min_m),
            closed=observation.boundary.closed,
            goal_spacing_m=p.goal_spacing_m,
        )

    def _aim_down_m(self, observation: Observation, target: TargetTrack | None, game: SpaceGame | None) -> float:
        """The height (down, m) to fly to: the evader's near it, the game point's far away; the own one without an evader."""
        if target is None:
            return float(observation.own.position_ned_m[2])
        p, place = self._parameters, float(target.position_ned_m[2])
        if game is None:
            return place
        n, e = (target.position_ned_m - observation.own.position_ned_m)[:2].tolist()
        far = (math.hypot(n, e) - p.slot_range_m) / (p.lead_range_m - p.slot_range_m)
        return place + min(1.0, max(0.0, far)) * (game.point_ned_m[2] - place)

    def _down_velocity_m_s(
        self, observation: Observation, target: TargetTrack | None, game: SpaceGame | None, room: VerticalRoom
    ) -> float:
        """To the height to fly to and along with the evader, braking before it; without an evader the height is kept."""
        p, down = self._parameters.volume, float(observation.own.position_ned_m[2])
        wanted = 0.0
        if target is not None:
            place = self._aim_down_m(observation, target, game)
            aim = min(-p.height_min_m, max(-p.height_max_m, place))
            gap = aim - down
            towards = min(p.gain_1_s * abs(gap), braking_speed_m_s(abs(gap), p.acceleration_max_m_s2, p.reaction_s))
            wanted = math.copysign(towards, gap) + (float(target.velocity_ned_m_s[2]) if aim == place else 0.0)
        last = float(observation.own.velocity_ned_m_s[2]) if self._down_m_s is None else self._down_m_s
        change = p.acceleration_max_m_s2 * observation.dt_s
        wanted = min(last + change, max(last - change, wanted))
        limits = self._limits
        climb, sink = min(limits.climb_rate_max_m_s, room.climb_max_m_s), min(limits.sink_rate_max_m_s, room.sink_max_m_s)
        self._down_m_s = min(sink, max(-climb, wanted))
        return self._down_m_s

    def _meeting_s(self, observation: Observation, target: TargetTrack) -> float:
        """When the evader can be met; NaN: never."""
        n, e, down = (target.position_ned_m - observation.own.position_ned_m).tolist()
        vn, ve, vd = target.velocity_ned_m_s.tolist()
        limits = self._limits
        rates = limits.climb_rate_max_m_s, limits.sink_rate_max_m_s
        return meeting_time_s((n, e, down), (vn, ve, vd), limits.speed_max_m_s, *rates)

    def _planar_share(self, observation: Observation, target: TargetTrack, velocity: Array) -> float:
        """The share of the planar velocity with which the vehicle arrives no sooner than at the evader's height.

        Only slower along the same way: what is free of obstacles stays so.
        """
        p = self._parameters
        n, e, down = (target.position_ned_m - observation.own.position_ned_m).tolist()
        distance, level_m = math.hypot(n, e), LEVEL_SHARE * p.capture.radius_m
        if not 0.0 < distance <= p.slot_range_m or abs(down) <= level_m:
            return 1.0
        rates = self._limits.climb_rate_max_m_s, self._limits.sink_rate_max_m_s
        rest_m = math.copysign(abs(down) - level_m, down)
        begin_s, end_s = vertical_interval_s(rest_m, float(target.velocity_ned_m_s[2]), *rates)
        allowed = 0.0 if begin_s > end_s else distance / begin_s if begin_s > 0.0 else math.inf
        along = float(velocity[0] * n + velocity[1] * e) / distance
        flees = float(target.velocity_ned_m_s[0] * n + target.velocity_ned_m_s[1] * e) / distance
        if along <= 0.0 or along - flees <= allowed:
            return 1.0
        return min(1.0, max(0.0, (allowed + flees) / along))

    def _is_captured(self, observation: Observation, target: TargetTrack | None, decision: Decision) -> bool:
        """The capture condition with height: the planar one, and the evader within reach of all of the team in space."""
        rule, before = self._parameters.capture, self._offset_m
        holds = False
        self._offset_m = None
        if target is not None:
            self._offset_m = offset = observation.own.position_ned_m - target.position_ned_m
            if rule.mode == "first":
                holds = closest_approach_m(offset if before is None else before, offset)[0] <= rule.radius_m
            else:
                places = (observation.own, *(member.state for member in observation.team))
                reach = max(float(np.linalg.norm(one.position_ned_m - target.position_ned_m)) for one in places)
                holds = decision.diagnostics["encircled"] is True and reach <= rule.zone_m
        self._dwell_since_s = dwell_since_s(self._dwell_since_s, observation.t_s, holds)
        if not holds:
            self._planar.missed()
        return has_dwelt(self._dwell_since_s, observation.t_s, rule.dwell_s)


def _present(observation: Observation, parameters: Ac2fParameters) -> TargetTrack | None:
    """The track moved to the observation's time; None where it is too old to be followed up or down."""
    track = observation.target
    if track is None or track.age_s > parameters.target_stale_s:
        return None
    ahead_s = min(parameters.prediction_max_s, max(0.0, observation.t_s - track.t_s))
    return replace(track, t_s=observation.t_s, position_ned_m=track.position_ned_m + ahead_s * track.velocity_ned_m_s)


def _moved(state: VehicleState, t_s: float, most_s: float) -> Array:
    """Where a teammate is at `t_s`, moved on with its velocity, over no more than `most_s`."""
    return state.position_ned_m + min(most_s, max(0.0, t_s - state.t_s)) * state.velocity_ned_m_s
