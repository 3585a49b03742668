"""The interception game in plain Python: what the compiled one is tested against.

A pursuer leaves the evader the points that the evader reaches no later: |p - p_i| >= lambda_i |p - p_e|. What all pursuers
together leave it is its dominance region. The game point is the point of this region nearest to the protected boundary.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from flightapp.planning.plane import (
    Point,
    Segment,
    nearest_on,
    nearest_on_segment,
    towards,
    unit,
)

EQUAL_SPEED = 1e-6  # |lambda - 1| below this is the half-plane
TOLERANCE_M = 1e-6


@dataclass(frozen=True, slots=True)
class Dominance:
    """What one pursuer leaves to the evader: inside of a disc (lambda > 1), a half-plane (== 1) or outside of a disc (< 1).

    For a half-plane `centre` is a point of its edge and `normal` points to the evader.
    """

    kind: Literal["disc", "half-plane", "outside"]
    centre: Point
    radius_m: float
    normal: Point

    def depth_m(self, point: Point) -> float:
        """Distance of `point` inside the edge; negative outside."""
        offset = (point[0] - self.centre[0], point[1] - self.centre[1])
        if self.kind == "half-plane":
            return offset[0] * self.normal[0] + offset[1] * self.normal[1]
        depth = self.radius_m - math.hypot(*offset)
        return depth if self.kind == "disc" else -depth

    def contains(self, point: Point) -> bool:
        return self.depth_m(point) >= -TOLERANCE_M * (1.0 + 1e-6 * self.radius_m)


@dataclass(frozen=True, slots=True)
class Game:
    """Solution for all pursuers: the game point, who is active there, and the goal of each pursuer."""

    point: Point
    contested: bool
    distance_m: float
    active: tuple[bool, ...]
    goals: tuple[Point, ...]
    regions: tuple[Dominance, ...]


def dominance(pursuer: Point, evader: Point, speed_ratio: float) -> Dominance:
    """The evader's dominance region against one pursuer with lambda = `speed_ratio` > 0."""
    away = towards(pursuer, evader)
    if abs(speed_ratio - 1.0) < EQUAL_SPEED and away != (0.0, 0.0):
        middle = ((pursuer[0] + evader[0]) / 2, (pursuer[1] + evader[1]) / 2)
        return Dominance("half-plane", middle, 0.0, away)
    square = speed_ratio * speed_ratio
    if abs(speed_ratio - 1.0) < EQUAL_SPEED:
        return Dominance("disc", evader, 0.0, away)
    scale = 1.0 / (square - 1.0)
    centre = (evader[0] + (evader[0] - pursuer[0]) * scale, evader[1] + (evader[1] - pursuer[1]) * scale)
    radius = speed_ratio * math.dist(pursuer, evader) * abs(scale)
    return Dominance("disc" if speed_ratio > 1.0 else "outside", centre, radius, away)


def solve(
    pursuers: Sequence[Point],
    evader: Point,
    speed_ratios: Sequence[float],
    sides: Sequence[Segment],
    *,
    closed: bool = False,
    union: bool = False,
    goal_spacing_m: float = 3.0,
) -> Game:
    """The game for `pursuers` (m) against `evader` before the boundary `sides`; `goal_spacing_m` keeps goals apart.

    In the union of the regions the game point is the best of the games against each pursuer alone.
    """
    regions = tuple(dominance(p, evader, ratio) for p, ratio in zip(pursuers, speed_ratios, strict=True))
    if closed and inside(evader, sides):
        return Game(evader, False, 0.0, (True,) * len(regions), (evader,) * len(regions), regions)
    if union and len(regions) > 1:
        alone = [solve([p], evader, [ratio], sides, closed=closed) for p, ratio in zip(pursuers, speed_ratios, strict=True)]
        lost = [game for game in alone if not game.contested]
        best = min(lost, key=lambda game: math.dist(game.point, evader)) if lost else min(alone, key=lambda game: game.distance_m)
        active = _active(best.point, pursuers, speed_ratios, regions)
        return Game(best.point, best.contested, best.distance_m, active, (), regions)
    reached = [point for point in _on_boundary(evader, regions, sides) if _in_all(point, regions)]
    if reached:
        point = min(reached, key=lambda candidate: math.dist(candidate, evader))
    else:
        point = min(
            (candidate for candidate in _on_edges(evader, regions, sides) if _in_all(candidate, regions)),
            key=lambda candidate: distance_to(candidate, sides),
        )
    active = _active(point, pursuers, speed_ratios, regions)
    goals = tuple(
        point if is_active else _gap_goal(point, pursuer, regions, goal_spacing_m)
        for pursuer, is_active in zip(pursuers, active, strict=True)
    )
    return Game(point, not reached, distance_to(point, sides), active, goals, regions)


def _in_all(point: Point, regions: Sequence[Dominance]) -> bool:
    return all(region.contains(point) for region in regions)


def _active(point: Point, pursuers: Sequence[Point], ratios: Sequence[float], regions: Sequence[Dominance]) -> tuple[bool, ...]:
    """The pursuers whose edge passes through the point; where none does, the ones that get there first."""
    on_edge = tuple(abs(region.depth_m(point)) < 1e-3 for region in regions)
    if any(on_edge):
        return on_edge
    leads = [math.dist(p, point) / ratio for p, ratio in zip(pursuers, ratios, strict=True)]
    return tuple(lead <= min(leads) + 1e-6 for lead in leads)


def _on_boundary(evader: Point, regions: Sequence[Dominance], sides: Sequence[Segment]) -> Iterator[Point]:
    """Where the evader could first reach the boundary: nearest points, corners, and edges of the regions on the boundary."""
    for side in sides:
        yield nearest_on_segment(evader, side)
        yield side[0]
        yield side[1]
        for region in regions:
            for point in _edge_and_line(region, side):
                if math.dist(point, nearest_on_segment(point, side)) < TOLERANCE_M:
                    yield point


def _on_edges(evader: Point, regions: Sequence[Dominance], sides: Sequence[Segment]) -> Iterator[Point]:
    """Candidates for the point nearest to the boundary: extreme points of each edge, and where two edges meet."""
    yield evader
    for region in regions:
        if region.kind == "half-plane":
            yield region.centre
        for (an, ae), (bn, be) in sides:
            along = unit((bn - an, be - ae))
            yield from _extremes(region, (-along[1], along[0]))
            for corner in ((an, ae), (bn, be)):
                yield _nearest_on_edge(region, corner)
    for index, first in enumerate(regions):
        for second in regions[index + 1 :]:
            yield from _edges_meet(first, second)


def _extremes(region: Dominance, normal: Point) -> Iterator[Point]:
    if region.kind != "half-plane":
        for sign in (1.0, -1.0):
            yield (
                region.centre[0] + sign * region.radius_m * normal[0],
                region.centre[1] + sign * region.radius_m * normal[1],
            )


def _nearest_on_edge(region: Dominance, point: Point) -> Point:
    if region.kind == "half-plane":
        depth = region.depth_m(point)
        return point[0] - depth * region.normal[0], point[1] - depth * region.normal[1]
    direction = towards(region.centre, point)
    return region.centre[0] + region.radius_m * direction[0], region.centre[1] + region.radius_m * direction[1]


def _edges_meet(first: Dominance, second: Dominance) -> Iterator[Point]:
    if first.kind == "half-plane":
        ahead = (first.centre[0] - first.normal[1], first.centre[1] + first.normal[0])
        yield from _edge_and_line(second, (first.centre, ahead))
    elif second.kind == "half-plane":
        yield from _edges_meet(second, first)
    else:
        yield from _circles_meet(first.centre, first.radius_m, second.centre, second.radius_m)


def _edge_and_line(region: Dominance, line: Segment) -> Iterator[Point]:
    (an, ae), (bn, be) = line
    along = unit((bn - an, be - ae))
    if region.kind == "half-plane":
        slope = along[0] * region.normal[0] + along[1] * region.normal[1]
        if abs(slope) > 1e-12:
            t = -region.depth_m((an, ae)) / slope
            yield an + t * along[0], ae + t * along[1]
        return
    middle = (region.centre[0] - an) * along[0] + (region.centre[1] - ae) * along[1]
    foot = (an + middle * along[0], ae + middle * along[1])
    height = math.dist(foot, region.centre)
    if height <= region.radius_m:
        half = math.sqrt((region.radius_m - height) * (region.radius_m + height))
        for sign in (1.0, -1.0):
            yield foot[0] + sign * half * along[0], foot[1] + sign * half * along[1]


def _circles_meet(a: Point, radius_a: float, b: Point, radius_b: float) -> Iterator[Point]:
    distance = math.dist(a, b)
    if distance == 0.0 or distance > radius_a + radius_b + TOLERANCE_M or distance < abs(radius_a - radius_b) - TOLERANCE_M:
        return
    along = (distance + (radius_a - radius_b) * (radius_a + radius_b) / distance) / 2
    half = math.sqrt(max(0.0, (radius_a - along) * (radius_a + along)))
    dn, de = (b[0] - a[0]) / distance, (b[1] - a[1]) / distance
    for sign in (1.0, -1.0):
        yield a[0] + along * dn - sign * half * de, a[1] + along * de + sign * half * dn


def _gap_goal(point: Point, pursuer: Point, regions: Sequence[Dominance], spacing_m: float) -> Point:
    """The point of the region's edge `spacing_m` beside the game point that is nearest to `pursuer`; else the game point."""
    beside: list[Point] = []
    for region in regions:
        if region.kind == "half-plane":
            ahead = (region.centre[0] - region.normal[1], region.centre[1] + region.normal[0])
            ring = Dominance("disc", point, spacing_m, (0.0, 0.0))
            beside.extend(_edge_and_line(ring, (region.centre, ahead)))
        else:
            beside.extend(_circles_meet(point, spacing_m, region.centre, region.radius_m))
    beside = [candidate for candidate in beside if _in_all(candidate, regions)]
    return min(beside, key=lambda candidate: math.dist(candidate, pursuer), default=point)


def distance_to(point: Point, sides: Sequence[Segment]) -> float:
    """Distance of `point` from a polyline, m."""
    return math.dist(point, nearest_on(point, sides))


def inside(point: Point, sides: Sequence[Segment]) -> bool:
    """Whether `point` lies inside the closed polygon of `sides`."""
    crossings = 0
    for (an, ae), (bn, be) in sides:
        if (ae > point[1]) != (be > point[1]) and point[0] < (bn - an) * (point[1] - ae) / (be - ae) + an:
            crossings += 1
    return crossings % 2 == 1
