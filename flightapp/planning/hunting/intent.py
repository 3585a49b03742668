"""What one hunter wants before it looks at obstacles: its phase, its goal, and with which velocity it goes there."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Limits, Rendezvous
from flightapp.planning.ac2f.arrival import arrival_time_s
from flightapp.planning.capture import CaptureRule
from flightapp.planning.hunting.hunt import away_m
from flightapp.planning.hunting.sight import View
from flightapp.planning.plane import Point, limited, towards, unit

HOLD, SEARCH, APPROACH, FORM, ENCLOSE = "hold", "search", "approach", "form", "enclose"
APPROACH_SHARE = 0.5
"""Of the acceleration, for approaching a slot: the rest steers."""
STEADY_SHARE = 0.15
"""Of the top speed: a slower target hardly moves."""
WAITING_SHARE = 0.05
"""Of the top speed: a slot that comes from behind is waited for until the wish leads on with it at least as fast as this."""
ARRIVED_SHARE = 0.15
"""Of the hunting radius (the source does not say when a slot is taken)."""


LEAD_FROM_SHARE, LEAD_SHARE = 0.8, 0.08
"""A target faster than this share of the top speed is led, at equal speeds by this share of the ring's radius."""
CONTACT_M_S = 1.5
"""Closing speed at the contact, where the first one ends the hunt."""


@dataclass(frozen=True, slots=True)
class Intent:
    """A wish: to `goal_m` with `velocity_m_s`; where that is 0, stand and look along `facing_rad`."""

    phase: str
    goal_m: Point
    velocity_m_s: Point
    facing_rad: float
    moves: bool = False
    """The goal flies away, with the target: its distance says nothing about how sharply to turn."""


def held_out_m(rendezvous: Rendezvous, bearing_rad: float, target_m: Point, target_radius_m: float, separation_m: float) -> float:
    """Distance of the own slot from the base point: twice as far out where the target comes in, until it is inside the ring."""
    radius = away_m(rendezvous.radius_m, rendezvous.slot)
    inside = math.dist((rendezvous.north_m, rendezvous.east_m), target_m) < rendezvous.radius_m
    if inside or rendezvous.closing or rendezvous.slot < 0:
        return radius
    width = math.asin(min(1.0, (1.5 * 2.0 * target_radius_m + separation_m) / rendezvous.radius_m))
    astern = abs(wrap_pi(bearing_rad - rendezvous.heading_rad - math.pi)) <= width
    return 2.0 * radius if astern and rendezvous.slots > 2 else radius


def intend(
    view: View,
    rendezvous: Rendezvous,
    bearing_rad: float,
    out_m: float,
    rule: CaptureRule,
    limits: Limits,
    follows: bool,
    period_s: float,
) -> Intent:
    """The wish of a hunter with a slot at `bearing_rad`, `out_m` from the base point. follows: it tracks the target itself."""
    slot = _around(view.target_m, bearing_rad, away_m(rendezvous.radius_m, rendezvous.slot))
    if rule.mode == "first" and _goes_first(view, limits):
        return _contact(view, rendezvous, limits)
    if follows:
        if math.dist(view.own_m, slot) > rendezvous.radius_m:
            return _still(APPROACH, view, slot, rendezvous.heading_rad, limits)
        return _moving(ENCLOSE, view, slot, rendezvous.heading_rad, rendezvous, limits, period_s)
    speed = math.hypot(*view.target_m_s)
    along = math.cos(rendezvous.heading_rad), math.sin(rendezvous.heading_rad)
    base = rendezvous.north_m, rendezvous.east_m
    left = (base[0] - view.target_m[0]) * along[0] + (base[1] - view.target_m[1]) * along[1]
    starting_m = speed**2 / (2.0 * APPROACH_SHARE * limits.acceleration_max_m_s2) + ARRIVED_SHARE * rendezvous.radius_m
    if rendezvous.closing or left <= starting_m:
        phase = ENCLOSE if view.distance_m <= 1.5 * away_m(rendezvous.radius_m, rendezvous.slot) else FORM
        return _moving(phase, view, slot, rendezvous.heading_rad, rendezvous, limits, period_s)
    return _still(APPROACH, view, _around(base, bearing_rad, out_m), rendezvous.heading_rad, limits)


def _around(centre: Point, bearing_rad: float, radius_m: float) -> Point:
    return centre[0] + radius_m * math.cos(bearing_rad), centre[1] + radius_m * math.sin(bearing_rad)


def _still(phase: str, view: View, place: Point, facing_rad: float, limits: Limits) -> Intent:
    """To a place that stands, braking before it."""
    distance = math.dist(view.own_m, place)
    if distance < max(0.5 * limits.body_radius_m, 0.02 * limits.speed_max_m_s):
        return Intent(phase, place, (0.0, 0.0), facing_rad)
    speed = min(limits.speed_max_m_s, _arriving_m_s(distance, limits))
    direction = towards(view.own_m, place)
    return Intent(phase, place, (speed * direction[0], speed * direction[1]), facing_rad)


def _moving(
    phase: str, view: View, slot: Point, facing_rad: float, rendezvous: Rendezvous, limits: Limits, period_s: float
) -> Intent:
    """To a slot that moves with the target, arriving with its velocity; a slot that comes from behind is waited for.

    Judged one control period ahead, which passes until a new speed is flown. A target about as fast as the vehicles is led by a
    little: who falls behind it never catches up, who is ahead waits.
    """
    speed = math.hypot(*view.target_m_s)
    equal = max(0.0, speed / limits.speed_max_m_s - LEAD_FROM_SHARE) / (1.0 - LEAD_FROM_SHARE)
    lead_m = min(1.0, equal) * LEAD_SHARE * rendezvous.radius_m
    ahead_s = lead_m / speed if speed > 0.0 else 0.0
    relative = view.target_m_s[0] - view.base_m_s[0], view.target_m_s[1] - view.base_m_s[1]
    north = slot[0] - view.own_m[0] + view.target_m_s[0] * ahead_s + relative[0] * period_s
    east = slot[1] - view.own_m[1] + view.target_m_s[1] * ahead_s + relative[1] * period_s
    away = math.hypot(north, east)
    closing = _arriving_m_s(away, limits)
    direction = unit((north, east))
    wish = limited(
        (view.target_m_s[0] + closing * direction[0], view.target_m_s[1] + closing * direction[1]), limits.speed_max_m_s
    )
    if speed > STEADY_SHARE * limits.speed_max_m_s:
        forward = (wish[0] * view.target_m_s[0] + wish[1] * view.target_m_s[1]) / speed
        behind = direction[0] * view.target_m_s[0] + direction[1] * view.target_m_s[1] < -0.5 * speed
        if behind and forward < WAITING_SHARE * limits.speed_max_m_s:
            return Intent(phase, slot, (0.0, 0.0), facing_rad, moves=True)
        return Intent(phase, slot, wish, facing_rad, moves=True)
    if away < 0.5 * limits.body_radius_m:
        facing_rad = math.atan2(view.target_m[1] - view.own_m[1], view.target_m[0] - view.own_m[0])
        return Intent(phase, slot, (0.0, 0.0), facing_rad)
    return Intent(phase, slot, wish, facing_rad)


def _arriving_m_s(distance_m: float, limits: Limits) -> float:
    """Speed from which the approach still stops within `distance_m`, gently at the end."""
    braking = APPROACH_SHARE * limits.acceleration_max_m_s2
    return min(math.sqrt(2.0 * braking * distance_m), 1.5 * distance_m, limits.speed_max_m_s)


def _goes_first(view: View, limits: Limits) -> bool:
    """Where the first contact ends the hunt: whether no teammate reaches the target sooner; of equals the one further south."""
    own = _reach_s(view, view.own_m, limits.speed_max_m_s), view.own_m[0]
    others = ((_reach_s(view, (row[0], row[1]), limits.speed_max_m_s), row[0]) for row in view.team.tolist())
    return all(own <= other for other in others)


def _reach_s(view: View, place: Point, speed_m_s: float) -> float:
    north, east = view.target_m[0] - place[0], view.target_m[1] - place[1]
    return float(arrival_time_s(north, east, *view.target_m_s, speed_m_s))


def _contact(view: View, rendezvous: Rendezvous, limits: Limits) -> Intent:
    """Straight to where the target is met."""
    after_s = _reach_s(view, view.own_m, limits.speed_max_m_s)
    place = view.target_m[0] + view.target_m_s[0] * after_s, view.target_m[1] + view.target_m_s[1] * after_s
    direction = towards(view.own_m, place)
    ahead = max(0.0, direction[0] * view.target_m_s[0] + direction[1] * view.target_m_s[1])
    closing = max(CONTACT_M_S, math.sqrt(2.0 * APPROACH_SHARE * limits.acceleration_max_m_s2 * view.distance_m))
    speed = min(limits.speed_max_m_s, ahead + closing)
    phase = ENCLOSE if view.distance_m < 3.0 * rendezvous.radius_m else APPROACH
    return Intent(phase, place, (speed * direction[0], speed * direction[1]), rendezvous.heading_rad)
