"""What a fast obstacle makes dangerous, and the nearest place to be out of its way (DAGRRT; CPPPEA 2.8, Li et al. 2025)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flightapp.core.clearance import way_gap_m
from flightapp.core.types import Array, Limits
from flightapp.planning.guidance.tree import Tree, is_barred
from flightapp.planning.meeting import rest_turn_s
from flightapp.planning.plane import Point

FAST_M_S = 0.2
RISK_RATIO = 1.5
"""Length of the risk zone over that of the danger zone."""
NODES = 200
CANDIDATES = 20
DIRECTIONS = 16
ASTERN_SHARE = 0.7
"""What a way behind the obstacle counts, of its time."""


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A moving disc, inflated."""

    place_m: Point
    velocity_m_s: Point
    radius_m: float

    @property
    def speed_m_s(self) -> float:
        return math.hypot(*self.velocity_m_s)


def danger_distance_m(
    obstacle: Obstacle, speed_m_s: float, limits: Limits, inflation_m: float, rule: Literal["clearing", "paper"]
) -> float:
    """d_s: how far ahead of the obstacle a vehicle at `speed_m_s` must have begun to clear its track.

    `clearing`: the obstacle's way while the vehicle turns and moves aside. `paper`: the printed formula, read as well as it can
    be: beyond most sensors' ranges.
    """
    turn_s = rest_turn_s(0.5 * math.pi, limits.yaw_rate_max_rad_s, limits.yaw_acceleration_max_rad_s2)
    size_m = 2.0 * max(0.0, obstacle.radius_m - inflation_m)
    if rule == "paper":
        turns_s = turn_s + rest_turn_s(math.pi, limits.yaw_rate_max_rad_s, limits.yaw_acceleration_max_rad_s2)
        top, a, v = limits.speed_max_m_s, limits.acceleration_max_m_s2, obstacle.speed_m_s
        return v * ((top + v) / a + turns_s) + (2.0 * size_m * a + top**2 + v**2) / (2.0 * a) + inflation_m
    clearing_s = turn_s + obstacle.radius_m / limits.speed_max_m_s
    return obstacle.speed_m_s * clearing_s + (2.0 / math.pi) * speed_m_s * turn_s + obstacle.radius_m


def is_in_zone(place_m: Point, obstacle: Obstacle, length_m: float) -> bool:
    """Whether `place_m` is in the capsule from the obstacle's centre along its velocity."""
    share = length_m / max(obstacle.speed_m_s, 1e-9)
    north, east = obstacle.place_m[0] - place_m[0], obstacle.place_m[1] - place_m[1]
    return bool(
        way_gap_m(north, east, share * obstacle.velocity_m_s[0], share * obstacle.velocity_m_s[1], obstacle.radius_m) <= 0.0
    )


def is_threatened(place_m: Point, velocity_m_s: Point, obstacle: Obstacle, length_m: float, ahead_s: float) -> bool:
    """In the danger zone, or in the risk zone and passed too near within `ahead_s` at the present velocity."""
    if is_in_zone(place_m, obstacle, length_m):
        return True
    if not is_in_zone(place_m, obstacle, RISK_RATIO * length_m):
        return False
    north, east = place_m[0] - obstacle.place_m[0], place_m[1] - obstacle.place_m[1]
    along_n = (velocity_m_s[0] - obstacle.velocity_m_s[0]) * ahead_s
    along_e = (velocity_m_s[1] - obstacle.velocity_m_s[1]) * ahead_s
    return bool(way_gap_m(north, east, along_n, along_e, obstacle.radius_m) <= 0.0)


def is_past(place_m: Point, velocity_m_s: Point, obstacle: Obstacle) -> bool:
    """Whether the distance grows."""
    north, east = place_m[0] - obstacle.place_m[0], place_m[1] - obstacle.place_m[1]
    v_n, v_e = velocity_m_s[0] - obstacle.velocity_m_s[0], velocity_m_s[1] - obstacle.velocity_m_s[1]
    return north * v_n + east * v_e > 0.0


def refuge_m(
    place_m: Point, course_rad: float, obstacle: Obstacle, length_m: float, standing: Array, limits: Limits, seed: int
) -> list[Point]:
    """Way to a place out of the capsule that is reached before the obstacle sweeps any of it; empty where none was found.

    Of the first that straight ways and a tree between the `standing` discs (m, >=3) reach, the soonest, rather astern than ahead.
    """
    reach = 2.0 * obstacle.radius_m + 0.5 * length_m
    box = place_m[0] - reach, place_m[1] - reach, place_m[0] + reach, place_m[1] + reach
    tree = Tree(place_m, place_m, box, 0.5 * obstacle.radius_m, NODES, seed, stops=False)
    tree.grow(standing, 2 * NODES)
    best: tuple[float, list[Point]] | None = None
    tried = 0
    for way in (*_straight_ways(place_m, obstacle, standing), *(tree.way_to(row) for row in range(1, tree.count))):
        node = way[-1]
        if is_in_zone(node, obstacle, RISK_RATIO * length_m):
            continue
        time_s = _unswept_s(way, course_rad, obstacle, limits)
        if time_s is None:
            continue
        away = (node[0] - place_m[0]) * obstacle.velocity_m_s[0] + (node[1] - place_m[1]) * obstacle.velocity_m_s[1]
        cost = time_s * (ASTERN_SHARE if away < 0.0 else 1.0)
        if best is None or cost < best[0]:
            best = cost, way[1:]
        tried += 1
        if tried == CANDIDATES:
            break
    return [] if best is None else best[1]


def _straight_ways(place_m: Point, obstacle: Obstacle, standing: Array) -> Iterator[list[Point]]:
    """Straight out of the track: a tree has few edges at its root, and may miss the only direction that is quick enough."""
    for k in range(DIRECTIONS):
        bearing = 2.0 * math.pi * k / DIRECTIONS
        for reach in (1.2 * obstacle.radius_m, 2.2 * obstacle.radius_m):
            node = place_m[0] + reach * math.cos(bearing), place_m[1] + reach * math.sin(bearing)
            if not is_barred(standing, *place_m, *node):
                yield [place_m, node]


def _unswept_s(way: list[Point], course_rad: float, obstacle: Obstacle, limits: Limits) -> float | None:
    """When the end of `way` is reached at top speed; None where the obstacle meets the vehicle on it."""
    first = math.atan2(way[1][1] - way[0][1], way[1][0] - way[0][0]) - course_rad
    turn = abs(math.remainder(first, 2.0 * math.pi))
    now_s = rest_turn_s(turn, limits.yaw_rate_max_rad_s, limits.yaw_acceleration_max_rad_s2)
    if _meets(way[0], way[0], 0.0, now_s, obstacle):
        return None
    for start, end in itertools.pairwise(way):
        then_s = now_s + math.dist(start, end) / limits.speed_max_m_s
        if _meets(start, end, now_s, then_s, obstacle):
            return None
        now_s = then_s
    return now_s


def _meets(start: Point, end: Point, from_s: float, until_s: float, obstacle: Obstacle) -> bool:
    v_n, v_e = obstacle.velocity_m_s
    north, east = start[0] - obstacle.place_m[0] - v_n * from_s, start[1] - obstacle.place_m[1] - v_e * from_s
    lasts_s = until_s - from_s
    gap = way_gap_m(north, east, end[0] - start[0] - v_n * lasts_s, end[1] - start[1] - v_e * lasts_s, obstacle.radius_m)
    return bool(gap < 0.0)


def moving_obstacles(rows: Array) -> list[Obstacle]:
    """Those among inflated discs (m, >=5) that move."""
    speeds = np.hypot(rows[:, 3], rows[:, 4])
    return [Obstacle((n, e), (v_n, v_e), radius) for n, e, radius, v_n, v_e, *_ in rows[speeds > FAST_M_S].tolist()]
