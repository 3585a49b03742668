"""The way to a slot that moves with the evader: around its keep-out, braking relative to it, its velocity fed forward."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.compiled import compiled
from flightapp.planning.plane import Point


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


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8)")
def _free_slot(scene: Array, north: float, east: float, radius_m: float, bearing_rad: float, slack_rad: float) -> float:
    best = bearing_rad
    best_gap = -1e9
    for step in range(13):
        side = 1.0 if step % 2 else -1.0
        shift = side * ((step + 1) // 2) / 6.0 * slack_rad
        n = north + radius_m * math.cos(bearing_rad + shift)
        e = east + radius_m * math.sin(bearing_rad + shift)
        gap = 0.3
        for i in range(scene.shape[0]):
            gap = min(gap, math.hypot(scene[i, 0] - n, scene[i, 1] - e) - scene[i, 2])
        if gap > best_gap + 1e-9:
            best_gap = gap
            best = bearing_rad + shift
    return best


def free_slot_bearing(obstacles: Array, evader_ahead: Point, slot: Slot, slack_rad: float) -> float:
    """The bearing within `slack_rad` of the slot's that is clear of `obstacles` (m, 6), the nearest such one."""
    if len(obstacles) == 0:
        return slot.bearing_rad
    contiguous = np.ascontiguousarray(obstacles)
    return wrap_pi(_free_slot(contiguous, evader_ahead[0], evader_ahead[1], slot.radius_m, slot.bearing_rad, slack_rad))


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
