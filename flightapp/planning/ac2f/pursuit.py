"""What one pursuer wants before it looks at obstacles: the game, its slot around the evader, its goal and its velocity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from flightapp.core.types import Array, Limits
from flightapp.planning.ac2f.apollonius import Game, solve
from flightapp.planning.ac2f.approach import Profile, Slot, approach_velocity, free_slot_bearing, intercept_time_s
from flightapp.planning.ac2f.arrival import arrival_time_s, speed_share
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.slots import slack_rad, slot_bearings
from flightapp.planning.ac2f.surroundings import Target
from flightapp.planning.plane import Point, planar, towards

SLOT_LOOK_AHEAD_S = 0.3


@dataclass(frozen=True, slots=True)
class Intent:
    """The wanted motion: goal (m), velocity (m/s), arrival (s), and the game that it came from."""

    goal: Point
    velocity: Point
    eta_s: float
    game: Game


@dataclass(frozen=True, slots=True)
class Pursuit:
    """The part of a pursuer that depends on vehicles and boundary only."""

    parameters: Ac2fParameters
    limits: Limits

    def intent(
        self,
        own: Point,
        team: Sequence[Point],
        team_eta_s: Sequence[float],
        target: Target,
        obstacles: Array,
        sides: Array,
        *,
        closed: bool,
        boundary_lost: bool,
    ) -> Intent:
        """The intent against `target`.

        obstacles: (m, 6), only to keep the slot free. sides: (s, 4) m. `boundary_lost` chases the evader itself.
        """
        parameters = self.parameters
        pursuers = (own, *team)
        game = self._game(pursuers, target, sides, closed)
        slot = self._slot(pursuers, target, obstacles)
        place = slot.place(target.position)
        eta_s = arrival_time_s(own, place, target.velocity, self.limits.speed_max_m_s)
        distance = math.dist(own, target.position)
        if distance <= parameters.slot_range_m:
            velocity = approach_velocity(own, target.position, target.velocity, slot, self._profile())
            return Intent(place, velocity, eta_s, game)
        goal = self._far_goal(own, place, target, game, distance, boundary_lost)
        share = 1.0
        if game.contested and game.distance_m >= parameters.arrival_margin_m:
            share = speed_share(eta_s, team_eta_s, parameters.arrival_window_s, parameters.arrival_slowdown_min)
        return Intent(goal, self.velocity_to(own, goal, share), eta_s, game)

    def velocity_to(self, own: Point, goal: Point, share: float = 1.0) -> Point:
        """Velocity (m/s) straight to a place that stands, braking before it."""
        brake = braking_speed_m_s(math.dist(own, goal), self._deceleration_m_s2, self.parameters.reaction_s)
        speed = min(share * self.limits.speed_max_m_s, brake)
        direction = towards(own, goal)
        return speed * direction[0], speed * direction[1]

    @property
    def evader_distance_m(self) -> float:
        """Smallest distance to keep from the evader: 0 where the capture needs contact."""
        keep_out = self.parameters.evader_keep_out_m
        return keep_out if self.parameters.capture.slot_radius_m > keep_out else 0.0

    def team_distance_m(self, count: int) -> float:
        """Smallest distance to keep from a teammate among `count` pursuers: less than configured only if the slots are closer."""
        if count < 2:
            return self.parameters.team_separation_m
        chord = 2.0 * self.parameters.capture.slot_radius_m * math.sin(math.pi / count)
        bodies = 2.0 * self.limits.body_radius_m + 0.05
        return min(self.parameters.team_separation_m, max(bodies, 0.95 * chord))

    @property
    def _deceleration_m_s2(self) -> float:
        return self.limits.acceleration_max_m_s2 * self.parameters.slot_braking_share

    def _profile(self) -> Profile:
        parameters = self.parameters
        return Profile(parameters.slot_gain_per_s, self._deceleration_m_s2, parameters.reaction_s, self.limits.speed_max_m_s)

    def _game(self, pursuers: Sequence[Point], target: Target, sides: Array, closed: bool) -> Game:
        evader_speed = max(self.parameters.evader_speed_assumed_m_s, math.hypot(*target.velocity))
        ratios = (self.limits.speed_max_m_s / evader_speed,) * len(pursuers)
        return solve(pursuers, target.position, ratios, sides, closed=closed, goal_spacing_m=self.parameters.goal_spacing_m)

    def _slot(self, pursuers: Sequence[Point], target: Target, obstacles: Array) -> Slot:
        parameters = self.parameters
        rule = parameters.capture
        keep_out = self.evader_distance_m
        way = min(keep_out + parameters.evader_path_margin_m, rule.slot_radius_m) if keep_out > 0.0 else 0.0
        assigned = Slot(slot_bearings(target.position, pursuers)[0], rule.slot_radius_m, way)
        ahead = (
            target.position[0] + SLOT_LOOK_AHEAD_S * target.velocity[0],
            target.position[1] + SLOT_LOOK_AHEAD_S * target.velocity[1],
        )
        slack = slack_rad(len(pursuers), rule.angular_gap_min_deg)
        return Slot(free_slot_bearing(obstacles, ahead, assigned, slack), rule.slot_radius_m, way)

    def _far_goal(self, own: Point, place: Point, target: Target, game: Game, distance_m: float, boundary_lost: bool) -> Point:
        """The game goal far away, the intercept of the predicted motion near the slot range, in between a blend of both.

        The game goal is moved towards the own slot, so that pursuers whose circles meet in the game point spread out early.
        """
        parameters = self.parameters
        time_s = intercept_time_s(own, place, target.velocity, self.limits.speed_max_m_s)
        if time_s is None:
            return target.position if boundary_lost else planar(game.goals[0])
        lead = (place[0] + time_s * target.velocity[0], place[1] + time_s * target.velocity[1])
        far = (distance_m - parameters.slot_range_m) / (parameters.lead_range_m - parameters.slot_range_m)
        share = 0.0 if boundary_lost else min(1.0, max(0.0, far))
        goal = planar(game.goals[0])
        spread_m = share * parameters.goal_spread_m if len(game.goals) > 1 else 0.0
        side = towards(target.position, place)
        north, east = lead[0] + share * (goal[0] - lead[0]), lead[1] + share * (goal[1] - lead[1])
        return north + spread_m * side[0], east + spread_m * side[1]
