"""A pursuer's intent in plain Python: what the compiled one is tested against."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from flightapp.core.angles import TWO_PI, wrap_pi
from flightapp.core.types import Array, Limits
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.plane import Point, Segment, towards
from tests.planning.apollonius_reference import Game, solve


def slot_bearings(evader: Point, pursuers: Sequence[Point]) -> tuple[float, ...]:
    """Bearing (rad, from the evader) of the slot of each of `pursuers`, equally spaced, with the least total rotation.

    The pursuers keep their order around the evader, so that no two ways cross. One pursuer keeps its own bearing.
    """
    count = len(pursuers)
    bearings = [math.atan2(e - evader[1], n - evader[0]) for n, e in pursuers]
    order = sorted(range(count), key=lambda index: (bearings[index], pursuers[index]))
    start = _after_widest_gap([bearings[index] for index in order])
    order = order[start:] + order[:start]
    first = bearings[order[0]]
    unwound = [first + (bearings[index] - first) % TWO_PI for index in order]
    spacing = TWO_PI / count
    turn = sum(bearing - rank * spacing for rank, bearing in enumerate(unwound)) / count
    slots = [0.0] * count
    for rank, index in enumerate(order):
        slots[index] = wrap_pi(turn + rank * spacing)
    return tuple(slots)


def slack_rad(count: int, angular_gap_min_deg: float) -> float:
    """How far one of `count` pursuers may leave its slot alone without opening the encirclement, with 5 deg to spare."""
    if count == 1:
        return math.pi
    free = math.pi - math.radians(angular_gap_min_deg) if count == 2 else math.pi - TWO_PI / count
    return max(0.0, free / 2 - math.radians(5.0))


def _after_widest_gap(ordered_rad: Sequence[float]) -> int:
    gaps = [(ordered_rad[rank] - ordered_rad[rank - 1]) % TWO_PI for rank in range(len(ordered_rad))]
    return max(range(len(gaps)), key=lambda rank: gaps[rank])


@dataclass(frozen=True, slots=True)
class Slot:
    """A place around the evader: bearing (rad) and radius (m) as seen from it, and the radius (m) of ways around it."""

    bearing_rad: float
    radius_m: float
    keep_out_m: float

    def place(self, evader: Point) -> Point:
        """The slot in the mission frame, m."""
        return (
            evader[0] + self.radius_m * math.cos(self.bearing_rad),
            evader[1] + self.radius_m * math.sin(self.bearing_rad),
        )


@dataclass(frozen=True, slots=True)
class Profile:
    """How fast a slot is approached, relative to the evader."""

    gain_per_s: float
    deceleration_m_s2: float
    reaction_s: float
    speed_max_m_s: float


def way_to_slot(own: Point, evader: Point, slot: Slot) -> tuple[Point, float]:
    """First direction (unit) and length (m) of the way from `own` to `slot`, in the frame that moves with the evader."""
    north, east = own[0] - evader[0], own[1] - evader[1]
    place = (slot.radius_m * math.cos(slot.bearing_rad), slot.radius_m * math.sin(slot.bearing_rad))
    to_slot = (place[0] - north, place[1] - east)
    length = math.hypot(*to_slot)
    if length < 1e-9:
        return (0.0, 0.0), 0.0
    distance = math.hypot(north, east)
    direct = (to_slot[0] / length, to_slot[1] / length)
    if slot.keep_out_m <= 0.0 or distance < 1e-9 or not _passes(north, east, to_slot, slot.keep_out_m):
        return direct, length
    bearing = math.atan2(east, north)
    turn = wrap_pi(slot.bearing_rad - bearing)
    side = math.copysign(1.0, turn)
    arc = slot.keep_out_m * abs(turn)
    if distance <= slot.keep_out_m:
        outwards = min(1.0, 2.0 * (slot.keep_out_m - distance) / slot.keep_out_m + 0.2)
        angle = bearing + side * math.acos(outwards)
        return (math.cos(angle), math.sin(angle)), arc + abs(slot.radius_m - distance)
    angle = bearing + math.pi - side * math.asin(slot.keep_out_m / distance)
    return (math.cos(angle), math.sin(angle)), max(length, distance - slot.keep_out_m + arc)


def approach_velocity(own: Point, evader: Point, evader_velocity: Point, slot: Slot, profile: Profile) -> Point:
    """Velocity (m/s) that flies to `slot` and stays there: the evader's plus as much along the way as profile and limit allow."""
    direction, length = way_to_slot(own, evader, slot)
    wanted = min(profile.gain_per_s * length, braking_speed_m_s(length, profile.deceleration_m_s2, profile.reaction_s))
    speed = min(wanted, _room(direction, evader_velocity, profile.speed_max_m_s))
    north, east = evader_velocity[0] + speed * direction[0], evader_velocity[1] + speed * direction[1]
    total = math.hypot(north, east)
    scale = min(1.0, profile.speed_max_m_s / total) if total > 0.0 else 1.0
    return north * scale, east * scale


def free_slot_bearing(discs: Array, ahead: Point, slot: Slot, slack: float) -> float:
    """The bearing within `slack` of the slot's that is clear of `discs` (m, 6), the nearest such one."""
    if len(discs) == 0:
        return slot.bearing_rad
    best, best_gap = slot.bearing_rad, -1e9
    for step in range(13):
        shift = (1.0 if step % 2 else -1.0) * ((step + 1) // 2) / 6.0 * slack
        place = Slot(slot.bearing_rad + shift, slot.radius_m, 0.0).place(ahead)
        gap = min(0.3, *(math.dist(place, (row[0], row[1])) - row[2] for row in discs.tolist()))
        if gap > best_gap + 1e-9:
            best, best_gap = slot.bearing_rad + shift, gap
    return wrap_pi(best)


def intercept_time_s(own: Point, place: Point, velocity: Point, speed_m_s: float) -> float | None:
    """When a vehicle at `own` with `speed_m_s` meets a place that moves with `velocity`; None if never."""
    north, east = place[0] - own[0], place[1] - own[1]
    a = velocity[0] ** 2 + velocity[1] ** 2 - speed_m_s**2
    b = north * velocity[0] + east * velocity[1]
    c = north * north + east * east
    if c == 0.0:
        return 0.0
    if abs(a) < 1e-9:
        return -c / (2.0 * b) if b < 0.0 else None
    discriminant = b * b - a * c
    if discriminant < 0.0:
        return None
    root = math.sqrt(discriminant)
    times = [t for t in ((-b - root) / a, (-b + root) / a) if t >= 0.0]
    return min(times, default=None)


def _passes(north: float, east: float, along: Point, keep_out_m: float) -> bool:
    length2 = along[0] ** 2 + along[1] ** 2
    fraction = min(1.0, max(0.0, -(north * along[0] + east * along[1]) / length2))
    return math.hypot(north + fraction * along[0], east + fraction * along[1]) < keep_out_m - 1e-6


def _room(direction: Point, drift: Point, speed_max_m_s: float) -> float:
    """The largest s >= 0 with |drift + s direction| <= speed_max."""
    b = direction[0] * drift[0] + direction[1] * drift[1]
    c = drift[0] ** 2 + drift[1] ** 2 - speed_max_m_s**2
    return max(0.0, -b + math.sqrt(max(0.0, b * b - c)))


def braking_speed_m_s(gap_m: float, deceleration_m_s2: float, reaction_s: float) -> float:
    """Highest speed that stops within `gap_m` after `reaction_s`."""
    if gap_m <= 0.0:
        return 0.0
    return deceleration_m_s2 * (math.sqrt(reaction_s**2 + 2.0 * gap_m / deceleration_m_s2) - reaction_s)


def arrival_time_s(own: Point, place: Point, velocity: Point, speed_m_s: float) -> float:
    """Estimated time until `own` with `speed_m_s` reaches a place that moves with `velocity`; straight to it if it never does."""
    time_s = intercept_time_s(own, place, velocity, speed_m_s)
    return math.dist(own, place) / speed_m_s if time_s is None else time_s


def speed_share(own_eta_s: float, team_eta_s: Sequence[float], window_s: float, share_min: float) -> float:
    """Share of the speed with which an early pursuer arrives no more than `window_s` before the last."""
    latest = max(team_eta_s, default=0.0) - window_s
    return 1.0 if latest <= own_eta_s else max(share_min, own_eta_s / latest)


@dataclass(frozen=True, slots=True)
class Target:
    """The evader now."""

    position: Point
    velocity: Point


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
        sides: Sequence[Segment],
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

    def _game(self, pursuers: Sequence[Point], target: Target, sides: Sequence[Segment], closed: bool) -> Game:
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
            target.position[0] + 0.3 * target.velocity[0],
            target.position[1] + 0.3 * target.velocity[1],
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
            return target.position if boundary_lost else game.goals[0]
        lead = (place[0] + time_s * target.velocity[0], place[1] + time_s * target.velocity[1])
        far = (distance_m - parameters.slot_range_m) / (parameters.lead_range_m - parameters.slot_range_m)
        share = 0.0 if boundary_lost else min(1.0, max(0.0, far))
        goal = game.goals[0]
        spread_m = share * parameters.goal_spread_m if len(game.goals) > 1 else 0.0
        side = towards(target.position, place)
        north, east = lead[0] + share * (goal[0] - lead[0]), lead[1] + share * (goal[1] - lead[1])
        return north + spread_m * side[0], east + spread_m * side[1]
