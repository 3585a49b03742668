"""Foxglove's primitives from recorded messages.

Foxglove's convention is right-handed with z up: x = east, y = north, z = up, metres about the mission's datum, frame
"mission". Yaw turns counter-clockwise from east, so yaw_enu = pi/2 - yaw_ned.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import foxglove.messages as fx
import numpy as np

from flightapp.config.mission import Mission

FRAME = "mission"
UPRIGHT = fx.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
CIRCLE_POINTS = 48
PATH_POINTS = 6
_TRUNK_M = 4.0
"""Drawn height of a disc of unknown height."""
_BLUE = fx.Color(r=0.12, g=0.37, b=0.75, a=1.0)
_RED = fx.Color(r=0.85, g=0.15, b=0.15, a=1.0)
_ORANGE = fx.Color(r=0.95, g=0.55, b=0.10, a=0.75)
_GREY = fx.Color(r=0.45, g=0.45, b=0.45, a=0.35)
_GREEN = fx.Color(r=0.10, g=0.60, b=0.25, a=1.0)
_TEAL = fx.Color(r=0.05, g=0.55, b=0.60, a=0.9)
_PALE_RED = fx.Color(r=0.85, g=0.15, b=0.15, a=0.25)


def stamp_of(time_ns: int) -> fx.Timestamp:
    return fx.Timestamp(sec=time_ns // 1_000_000_000, nsec=time_ns % 1_000_000_000)


def enu(ned_m: Sequence[float]) -> fx.Vector3:
    return fx.Vector3(x=ned_m[1], y=ned_m[0], z=-ned_m[2])


def turned(heading_rad: float) -> fx.Quaternion:
    """Of something that looks along `heading_rad`, clockwise from north."""
    half = (math.pi / 2 - heading_rad) / 2
    return fx.Quaternion(x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))


def discs(message: Mapping[str, Any], stamp: fx.Timestamp) -> fx.SceneEntity:
    """Of one `/obstacles`."""
    return _entity("discs", stamp, cylinders=[_disc(row) for row in message["discs"]])


def target(message: Mapping[str, Any], stamp: fx.Timestamp) -> fx.SceneEntity:
    """Of one `/target`: red, as large as its uncertainty where that is more than the vehicle itself."""
    across_m = max(0.7, 2.0 * message["position_sigma_m"])
    return _entity("target", stamp, spheres=[_ball(message["position_ned_m"], across_m, _RED)])


def teammates(message: Mapping[str, Any], stamp: fx.Timestamp) -> fx.SceneEntity:
    """Of one `/team`: a ball and a name each."""
    balls, names = [], []
    for member in message["members"]:
        place = member["position_ned_m"]
        balls.append(_ball(place, 0.5, _RED if member["role"] == "evader" else _BLUE))
        above = fx.Pose(position=enu([place[0], place[1], place[2] - 0.8]), orientation=UPRIGHT)
        names.append(
            fx.TextPrimitive(pose=above, billboard=True, font_size=12.0, scale_invariant=True, color=_BLUE, text=member["name"])
        )
    return _entity("team", stamp, spheres=balls, texts=names)


def intent(message: Mapping[str, Any], height_m: float, stamp: fx.Timestamp) -> fx.SceneEntity:
    """Of one `/decision`: goal, point of the game, and the Apollonius circles that the planner put into its diagnostics."""
    found = message["diagnostics"]
    circles = [_circle(north_m, east_m, radius_m, height_m) for north_m, east_m, radius_m in found.get("circles") or ()]
    balls = []
    if message["goal_ned_m"] is not None:
        north_m, east_m, _ = message["goal_ned_m"]
        balls.append(_ball((north_m, east_m, -height_m), 0.5, _GREEN))
    if found.get("game_point") is not None:
        north_m, east_m = found["game_point"]
        balls.append(_ball((north_m, east_m, -height_m), 0.4, _TEAL))
    return _entity("intent", stamp, lines=circles, spheres=balls)


def paths(message: Mapping[str, Any], stamp: fx.Timestamp) -> fx.SceneEntity:
    """Of one `/candidates`: rejected ones pale red, admissible ones from yellow to green by score, the best one thick."""
    scores = message["score"]
    open_scores = [score for score, verdict in zip(scores, message["verdict"], strict=True) if verdict == 0]
    low, high = (min(open_scores), max(open_scores)) if open_scores else (0.0, 0.0)
    lines = []
    for row, points in enumerate(_arcs(message)):
        share = (scores[row] - low) / (high - low) if high > low else 1.0
        color = _PALE_RED if message["verdict"][row] else fx.Color(r=0.9 * (1.0 - share), g=0.75, b=0.1, a=0.4 + 0.4 * share)
        best = row == message["best"]
        thickness = 0.06 if best else 0.015
        lines.append(
            fx.LinePrimitive(
                type=fx.LinePrimitiveLineType.LineStrip, thickness=thickness, points=points, color=_GREEN if best else color
            )
        )
    return _entity("paths", stamp, lines=lines)


def nothing(name: str, stamp: fx.Timestamp) -> fx.SceneEntity:
    """Takes the place of an entity that is not true any more."""
    return _entity(name, stamp)


def surroundings(mission: Mission, stamp: fx.Timestamp) -> fx.SceneEntity:
    """Protected boundary (red), fence (blue) and surveyed obstacles (grey)."""
    height_m = mission.height_m
    cylinders = [_cylinder(c.north_m, c.east_m, c.radius_m, 0.0, c.height_m, _GREY) for c in mission.obstacles.cylinders]
    cubes = []
    for box in mission.obstacles.boxes:
        centre = fx.Vector3(x=box.east_m, y=box.north_m, z=box.height_m / 2)
        size = fx.Vector3(x=box.length_m, y=box.width_m, z=box.height_m)
        pose = fx.Pose(position=centre, orientation=turned(math.radians(box.heading_deg)))
        cubes.append(fx.CubePrimitive(pose=pose, size=size, color=_GREY))
    lines = [
        _line(mission.boundary.vertices_m, mission.boundary.closed, height_m, _RED),
        _line(mission.flight_volume.vertices_m, True, height_m, _BLUE),
    ]
    return _entity("mission", stamp, lines=lines, cylinders=cylinders, cubes=cubes)


def _entity(name: str, stamp: fx.Timestamp, **primitives: Any) -> fx.SceneEntity:
    return fx.SceneEntity(timestamp=stamp, frame_id=FRAME, id=name, **primitives)


def _arcs(message: Mapping[str, Any]) -> list[list[fx.Point3]]:
    """Points of each candidate's arc: constant speed and turn rate from the own position and course."""
    speeds, turns = np.array(message["speed_m_s"]), np.array(message["turn_rad_s"])
    times = np.linspace(0.0, message["horizon_s"], PATH_POINTS)
    halves = 0.5 * np.outer(turns, times)
    chords = np.outer(speeds, times) * np.sinc(halves / math.pi)
    bearings = message["course_rad"] + halves
    norths, easts = message["north_m"] + chords * np.cos(bearings), message["east_m"] + chords * np.sin(bearings)
    up_m = -message["down_m"]
    return [
        [fx.Point3(x=east_m, y=north_m, z=up_m) for north_m, east_m in zip(*row, strict=True)]
        for row in zip(norths.tolist(), easts.tolist(), strict=True)
    ]


def _ball(ned_m: Sequence[float], across_m: float, color: fx.Color) -> fx.SpherePrimitive:
    size = fx.Vector3(x=across_m, y=across_m, z=across_m)
    return fx.SpherePrimitive(pose=fx.Pose(position=enu(ned_m), orientation=UPRIGHT), size=size, color=color)


def _disc(row: Sequence[float | None]) -> fx.CylinderPrimitive:
    """A row of `Obstacles.discs`; null heights (infinite, which JSON cannot say) are drawn from the datum up."""
    north_m, east_m, radius_m, _, _, down_top_m, down_bottom_m = row
    assert north_m is not None
    assert east_m is not None
    assert radius_m is not None
    bottom_m = 0.0 if down_bottom_m is None else -down_bottom_m
    top_m = bottom_m + _TRUNK_M if down_top_m is None else -down_top_m
    return _cylinder(north_m, east_m, radius_m, bottom_m, top_m, _ORANGE)


def _cylinder(
    north_m: float, east_m: float, radius_m: float, bottom_m: float, top_m: float, color: fx.Color
) -> fx.CylinderPrimitive:
    centre = fx.Vector3(x=east_m, y=north_m, z=(bottom_m + top_m) / 2)
    size = fx.Vector3(x=2 * radius_m, y=2 * radius_m, z=top_m - bottom_m)
    return fx.CylinderPrimitive(
        pose=fx.Pose(position=centre, orientation=UPRIGHT), size=size, bottom_scale=1.0, top_scale=1.0, color=color
    )


def _circle(north_m: float, east_m: float, radius_m: float, height_m: float) -> fx.LinePrimitive:
    angles = [2.0 * math.pi * number / CIRCLE_POINTS for number in range(CIRCLE_POINTS)]
    vertices = [(north_m + radius_m * math.cos(angle), east_m + radius_m * math.sin(angle)) for angle in angles]
    return _line(vertices, True, height_m, _TEAL)


def _line(vertices_m: Sequence[tuple[float, float]], closed: bool, height_m: float, color: fx.Color) -> fx.LinePrimitive:
    kind = fx.LinePrimitiveLineType.LineLoop if closed else fx.LinePrimitiveLineType.LineStrip
    points = [fx.Point3(x=east_m, y=north_m, z=height_m) for north_m, east_m in vertices_m]
    return fx.LinePrimitive(type=kind, thickness=0.08, points=points, color=color)
