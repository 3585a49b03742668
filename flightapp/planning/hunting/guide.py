"""When a hunter is guided, and to which point: out of traps (SAGRRT) and out of the way of fast obstacles (DAGRRT)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array, Limits
from flightapp.planning.guidance.danger import (
    Obstacle,
    danger_distance_m,
    is_past,
    is_threatened,
    moving_obstacles,
    refuge_m,
)
from flightapp.planning.guidance.key_points import key_points
from flightapp.planning.guidance.tree import Tree, is_barred
from flightapp.planning.hunting.intent import Intent
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.hunting.sight import View
from flightapp.planning.hunting.window import all_rays_hit
from flightapp.planning.meeting import rest_turn_s
from flightapp.planning.plane import Point, towards

FAILURES_MAX = 3
PROGRESS_SHARE = 0.2
"""Of the way at top speed: less progress than this is none."""
LEG_SHARE = 0.05
"""The same of the way to a key point, which is flown to along obstacles."""
OUTSIDE = 1.01
"""Of its radius: so far from its centre is outside of a disc."""
EDGES, EDGE_POINTS = 12, 16
"""Of so many discs next to a covered goal so many points around are tried."""
TRAP, FAST, BLOCKED = "guided out of a trap", "giving way to a fast obstacle", "blocked: no way was found"


class Guide:
    """The guidance points in force, and the search for new ones, which goes on over several control periods."""

    def __init__(self, parameters: HuntingParameters, limits: Limits, seed: int) -> None:
        self._parameters, self._limits, self._seed = parameters, limits, seed
        rates = limits.yaw_rate_max_rad_s, limits.yaw_acceleration_max_rad_s2
        self._quarter_turn_s = rest_turn_s(0.5 * math.pi, *rates)
        self._inflation_m = limits.body_radius_m + limits.safety_margin_m
        self._margin_m = 0.5 * limits.body_radius_m
        self._points: list[Point] = []
        self._tree: Tree | None = None
        self._searches = self._failures = self._blocked_cycles = self._free_cycles = 0
        self._progress: tuple[float, float] | None = None
        self._leg: tuple[Point, float, float] | None = None
        """The key point that is flown to, and when it was how near, the last time that was progress."""
        self._fleeing: list[Point] = []
        self.why = ""
        self.goal_is_covered = False
        """By a standing obstacle: the nearest free place is the goal then."""

    def step(self, view: View, intent: Intent, wanted: bool) -> Point | None:
        """The point to fly to in place of the intent's goal; None: that goal itself."""
        self.goal_is_covered = False
        if not wanted:
            return None
        standing = _standing(view.scene[: view.obstacles])
        point = self._flee(view, standing)
        if point is not None:
            self.why = FAST
            return point
        if intent.velocity_m_s == (0.0, 0.0):
            self._forget()
            return None
        goal = outside_m(intent.goal_m, standing)
        self.goal_is_covered = goal != intent.goal_m
        self._detect(view, goal, standing)
        self._search(view, goal, standing)
        point = self._follow(view, goal, standing)
        if point is not None:
            self.why = BLOCKED if self.is_blocked else TRAP
        return point

    @property
    def is_blocked(self) -> bool:
        """Search after search has found no way."""
        return self._failures >= FAILURES_MAX

    def fan_length_m(self, speed_m_s: float) -> float:
        """rho: what braking and a quarter turn need."""
        body, a = self._limits.body_radius_m, self._limits.acceleration_max_m_s2
        length = speed_m_s**2 / (2.0 * a) + speed_m_s * self._quarter_turn_s + 2.0 * body
        return max(4.0 * body, min(length, self._parameters.guidance_range_m))

    def _forget(self) -> None:
        self._points, self._tree, self._progress, self._leg = [], None, None, None
        self._blocked_cycles = self._free_cycles = self._failures = 0

    def _detect(self, view: View, goal: Point, standing: Array) -> None:
        """Begin a search at a stall: all rays hit, or no progress although something stands in the way."""
        if self._points or self._tree is not None:
            return
        distance = math.dist(view.own_m, goal)
        half = math.radians(self._parameters.fan_half_angle_deg)
        speed = max(view.speed_m_s, 0.3 * self._limits.speed_max_m_s)
        hit = bool(all_rays_hit(standing, *view.own_m, view.course_rad, half, self.fan_length_m(speed), distance))
        barred = bool(is_barred(standing, *view.own_m, *goal))
        self._blocked_cycles = self._blocked_cycles + 1 if hit and barred else 0
        if not barred:
            self._progress = None
            return
        if self._progress is None:
            self._progress = view.t_s, distance
        since_s, before = self._progress
        stalled = self._blocked_cycles >= self._parameters.stall_cycles
        if view.t_s - since_s >= self._parameters.stall_progress_s:
            least = PROGRESS_SHARE * self._limits.speed_max_m_s * self._parameters.stall_progress_s
            stalled = stalled or before - distance < least
            self._progress = view.t_s, distance
        if stalled:
            self._begin(view, goal, standing)

    def _begin(self, view: View, goal: Point, standing: Array) -> None:
        places = np.concatenate((np.array([view.own_m, goal]), standing[:, :2]))
        extent = max(np.ptp(places[:, 0]), np.ptp(places[:, 1]))
        speed = self._limits.speed_max_m_s
        step_m = min(2.0 * self._limits.body_radius_m + 0.25 * self.fan_length_m(speed), 0.05 * float(extent) + 0.1)
        room = min(self._parameters.guidance_range_m, 0.25 * float(extent) + 4.0 * step_m)
        low, high = places.min(axis=0) - room, places.max(axis=0) + room
        self._searches += 1
        seed = self._seed + 1000003 * self._searches
        box = float(low[0]), float(low[1]), float(high[0]), float(high[1])
        self._tree = Tree(view.own_m, goal, box, step_m, self._parameters.guidance_nodes, seed)
        self._blocked_cycles, self._progress = 0, None

    def _search(self, view: View, goal: Point, standing: Array) -> None:
        """Go on with the search; where it ends, its key points are flown."""
        tree = self._tree
        if tree is None:
            return
        wide = _grown(standing, view.own_m, goal, self._margin_m)
        tree.grow(wide, self._parameters.guidance_nodes_a_step)
        if not tree.has_found and not tree.is_exhausted:
            return
        self._tree, self._free_cycles = None, 0
        self._failures = 0 if tree.has_found else self._failures + 1
        way = tree.way()
        try:
            self._points = key_points(way, wide)
        except ValueError:
            self._points = []  # a disc was seen meanwhile that stands in it: the next stall searches again

    def _follow(self, view: View, goal: Point, standing: Array) -> Point | None:
        """The first key point not reached yet; none once the straight way to the goal has been free for a while."""
        if not self._points:
            return None
        free = not is_barred(standing, *view.own_m, *goal)
        self._free_cycles = self._free_cycles + 1 if free else 0
        if self._free_cycles >= self._parameters.guidance_free_cycles:
            self._forget()
            return None
        near = max(2.0 * self._limits.body_radius_m, view.speed_m_s**2 / (2.0 * self._limits.acceleration_max_m_s2))
        while self._points and math.dist(view.own_m, self._points[0]) < near:
            if len(self._points) > 1 and is_barred(standing, *view.own_m, *self._points[1]):
                break
            self._points.pop(0)
        while len(self._points) > 1 and not is_barred(standing, *view.own_m, *self._points[1]):
            self._points.pop(0)
        if not self._points:
            return None
        if self._tree is None and is_barred(standing, *view.own_m, *self._points[0]):
            self._points = []
            self._begin(view, goal, standing)
            return None
        if self._is_stuck(view, self._points[0]):
            self._points, self._failures = [], self._failures + 1
            self._begin(view, goal, standing)
            return None
        return self._points[0]

    def _is_stuck(self, view: View, point: Point) -> bool:
        """Whether a key point comes no nearer, as one so close to an obstacle that the window does not let the vehicle there."""
        distance = math.dist(view.own_m, point)
        least = LEG_SHARE * self._limits.speed_max_m_s * self._parameters.stall_progress_s
        if self._leg is None or self._leg[0] != point or distance <= self._leg[2] - least:
            self._leg = point, view.t_s, distance
        return view.t_s - self._leg[1] >= self._parameters.stall_progress_s

    def _flee(self, view: View, standing: Array) -> Point | None:
        """A place out of the way of what comes fast; kept until it is past."""
        threats = []
        for obstacle in moving_obstacles(view.scene[: view.obstacles]):
            if obstacle.speed_m_s < 0.5 * self._limits.speed_max_m_s:
                continue
            length = danger_distance_m(
                obstacle, view.speed_m_s, self._limits, self._inflation_m, self._parameters.danger_distance
            )
            ahead_s = 1.5 * length / obstacle.speed_m_s
            if self._fleeing and is_past(view.own_m, view.base_m_s, obstacle):
                continue
            if self._fleeing or is_threatened(view.own_m, view.base_m_s, obstacle, length, ahead_s):
                threats.append((math.dist(view.own_m, obstacle.place_m), obstacle, length))
        if not threats:
            self._fleeing = []
            return None
        _, nearest, length = min(threats, key=lambda threat: threat[0])
        if not self._fleeing:
            self._fleeing = self._refuge(view, nearest, length, standing)
        while len(self._fleeing) > 1 and math.dist(view.own_m, self._fleeing[0]) < 2.0 * self._limits.body_radius_m:
            self._fleeing.pop(0)
        return self._fleeing[0] if self._fleeing else None

    def _refuge(self, view: View, obstacle: Obstacle, length_m: float, standing: Array) -> list[Point]:
        self._searches += 1
        seed = self._seed + 1000003 * self._searches
        return refuge_m(view.own_m, view.course_rad, obstacle, length_m, standing, self._limits, seed)


def outside_m(place: Point, standing: Array) -> Point:
    """`place`, or where it is inside a disc the point of its edge next to it; where others cover that, a near free one."""
    for n, e, radius, *_ in standing.tolist():
        away = math.hypot(place[0] - n, place[1] - e)
        if away < radius:
            along = towards((n, e), place) if away > 0.0 else (1.0, 0.0)
            beside = n + OUTSIDE * radius * along[0], e + OUTSIDE * radius * along[1]
            return beside if _are_free(np.array([beside]), standing)[0] else _free_edge_m(place, standing, beside)
    return place


def _free_edge_m(place: Point, standing: Array, otherwise: Point) -> Point:
    """The point nearest to `place` around the discs next to it that no disc covers."""
    gaps = np.hypot(standing[:, 0] - place[0], standing[:, 1] - place[1]) - standing[:, 2]
    near = standing[np.argsort(gaps, kind="stable")[:EDGES]]
    bearings = np.arange(EDGE_POINTS) * (2.0 * math.pi / EDGE_POINTS)
    around = np.stack((np.cos(bearings), np.sin(bearings)), axis=-1)
    places = (near[:, None, :2] + OUTSIDE * near[:, None, 2:3] * around).reshape(-1, 2)
    free = places[_are_free(places, standing)]
    if not len(free):
        return otherwise
    n, e = free[int(np.argmin(np.hypot(free[:, 0] - place[0], free[:, 1] - place[1])))].tolist()
    return n, e


def _are_free(places: Array, standing: Array) -> NDArray[np.bool_]:
    """(n,) for places (n, 2)."""
    away = places[:, None, :] - standing[None, :, :2]
    return np.asarray((np.hypot(away[..., 0], away[..., 1]) >= standing[:, 2]).all(axis=1))


def _standing(rows: Array) -> Array:
    """The inflated discs among rows (m, >=5) that do not move."""
    return np.ascontiguousarray(rows[(rows[:, 3] == 0.0) & (rows[:, 4] == 0.0)])


def _grown(discs: Array, own: Point, goal: Point, margin_m: float) -> Array:
    """`discs` with a margin, but never around the start or the goal."""
    wide = discs.copy()
    apart = np.minimum(np.hypot(wide[:, 0] - own[0], wide[:, 1] - own[1]), np.hypot(wide[:, 0] - goal[0], wide[:, 1] - goal[1]))
    wide[:, 2] = np.maximum(wide[:, 2], np.minimum(wide[:, 2] + margin_m, 0.99 * apart))
    return wide
