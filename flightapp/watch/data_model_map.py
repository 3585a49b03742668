"""The mission from above, north up: fence, protected boundary, surveyed obstacles, vehicles with heading and name, the target."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from shapely.geometry import Polygon

from flightapp.config.mission import Box, Mission
from flightapp.watch.data_model_canvas import DOTS_ACROSS, DOTS_DOWN, Canvas, Dot, Ink
from flightapp.watch.data_model_fleet import Overview
from flightapp.watch.data_model_rows import Link, Row
from flightapp.watch.data_model_target import TELEMETRY

ARROWS = "↑↗→↘↓↙←↖"
"""By heading in eighths of a turn, clockwise from north."""
LOST = "?"
SEEN = "✕"
"""In place of the arrow where only cameras see the target: its heading is not known."""
CIRCLE_CORNERS = 12
FENCE_EVERY = 2

Place = tuple[float, float]
"""North and east, m."""


class MapView:
    """Where a place lies on a canvas: the whole contingency volume fits, one scale in both directions."""

    def __init__(self, mission: Mission, columns: int, rows: int) -> None:
        volume = mission.flight_volume
        outline = Polygon(volume.contingency_vertices_m or volume.vertices_m)
        if volume.contingency_vertices_m is None:
            outline = outline.buffer(volume.contingency_m)
        south, west, north, east = outline.bounds
        self._across, self._down = columns * DOTS_ACROSS, rows * DOTS_DOWN
        self.dot_m = max((east - west) / max(1, self._across - 1), (north - south) / max(1, self._down - 1))
        self._north, self._east = (north + south) / 2.0, (east + west) / 2.0

    def dot(self, place: Place) -> Dot:
        """Also outside the canvas."""
        return (
            self._across / 2.0 + (place[1] - self._east) / self.dot_m,
            self._down / 2.0 - (place[0] - self._north) / self.dot_m,
        )


def draw_map(mission: Mission, overview: Overview, columns: int, rows: int) -> Canvas:
    """At most a few hundred dots. Vehicles outside the picture stand at its edge."""
    canvas, view = Canvas(columns, rows), MapView(mission, columns, rows)

    def path(places: Iterable[Place], ink: Ink, every: int = 1) -> None:
        canvas.path([view.dot(place) for place in places], ink, every)

    path(_closed(mission.flight_volume.vertices_m), Ink.FENCE, FENCE_EVERY)
    boundary = mission.boundary
    path(_closed(boundary.vertices_m) if boundary.closed else boundary.vertices_m, Ink.BOUNDARY)
    for cylinder in mission.obstacles.cylinders:
        path(_circle(cylinder.north_m, cylinder.east_m, cylinder.radius_m), Ink.OBSTACLE)
    for box in mission.obstacles.boxes:
        path(_corners(box), Ink.OBSTACLE)
    for row in overview.rows:
        _draw_name(canvas, view, row)
    for row in overview.rows:
        _draw_vehicle(canvas, view, row)
    target = overview.target
    if target is not None and target.source != TELEMETRY:
        canvas.text(view.dot((target.north_m, target.east_m)), SEEN + target.name, Ink.EVADER)
    return canvas


def _draw_name(canvas: Canvas, view: MapView, row: Row) -> None:
    """And the goal: whatever else is there covers them."""
    if row.state is None or row.link is Link.OVER:
        return
    if row.state.goal_ned_m is not None and row.link is not Link.LOST:
        canvas.dot(view.dot(row.state.goal_ned_m[:2]), Ink.GOAL)
    across, down = view.dot(row.state.position_ned_m[:2])
    canvas.text((across + DOTS_ACROSS, down), row.name, _ink(row))


def _draw_vehicle(canvas: Canvas, view: MapView, row: Row) -> None:
    if row.state is None or row.link is Link.OVER:
        return
    sign = LOST if row.link is Link.LOST else arrow(row.state.yaw_rad)
    canvas.text(view.dot(row.state.position_ned_m[:2]), sign, _ink(row))


def _ink(row: Row) -> Ink:
    if row.link is Link.LOST:
        return Ink.LOST
    return Ink.EVADER if row.role == "evader" else Ink.PURSUER


def arrow(yaw_rad: float) -> str:
    """The nearest of eight directions, seen from above."""
    return ARROWS[round(yaw_rad / (math.pi / 4.0)) % 8]


def _closed(vertices: Sequence[Place]) -> list[Place]:
    return [*vertices, vertices[0]]


def _circle(north_m: float, east_m: float, radius_m: float) -> list[Place]:
    angles = [2.0 * math.pi * corner / CIRCLE_CORNERS for corner in range(CIRCLE_CORNERS + 1)]
    return [(north_m + radius_m * math.cos(angle), east_m + radius_m * math.sin(angle)) for angle in angles]


def _corners(box: Box) -> list[Place]:
    heading = math.radians(box.heading_deg)
    along = (math.cos(heading) * box.length_m / 2.0, math.sin(heading) * box.length_m / 2.0)
    across = (-math.sin(heading) * box.width_m / 2.0, math.cos(heading) * box.width_m / 2.0)
    signs = ((1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1))
    return [(box.north_m + a * along[0] + b * across[0], box.east_m + a * along[1] + b * across[1]) for a, b in signs]
