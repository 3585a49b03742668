"""What makes a recording open usefully in Foxglove: pose, scene and log in its well-known schemas.

Foxglove's convention is right-handed with z up: x = east, y = north, z = up, metres about the mission's datum, frame
"mission". Yaw turns counter-clockwise from east, so yaw_enu = pi/2 - yaw_ned.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import foxglove.messages as fx
import orjson
from foxglove import Context
from foxglove.channels import LogChannel, PoseInFrameChannel, SceneUpdateChannel

from flightapp.config.mission import Mission

FRAME = "mission"
_POSE_PERIOD_NS = 100_000_000
_SCENE_PERIOD_NS = 200_000_000
_TRUNK_M = 4.0
"""Drawn height of a disc of unknown height."""
_BLUE = fx.Color(r=0.12, g=0.37, b=0.75, a=1.0)
_RED = fx.Color(r=0.85, g=0.15, b=0.15, a=1.0)
_ORANGE = fx.Color(r=0.95, g=0.55, b=0.10, a=0.75)
_GREY = fx.Color(r=0.45, g=0.45, b=0.45, a=0.35)
_LEVELS = {"info": fx.LogLevel.Info, "warning": fx.LogLevel.Warning, "error": fx.LogLevel.Error}


class View:
    """Derives the view from recorded messages, at a rate that people see; one instance a recording."""

    def __init__(self, context: Context, mission: Mission | None) -> None:
        self._pose = PoseInFrameChannel("/view/pose", context=context)
        self._scene = SceneUpdateChannel("/view/scene", context=context)
        self._log = LogChannel("/log", context=context)
        self._mission = mission
        self._pose_due_ns = 0
        self._scene_due_ns = 0
        self._latest: dict[str, bytes] = {}

    def feed(self, topic: str, payload: bytes, time_ns: int) -> None:
        """Take note of one recorded message and log what follows from it."""
        if topic == "/event":
            self._log_event(orjson.loads(payload), time_ns)
        elif topic in ("/target", "/obstacles"):
            self._latest[topic] = payload
        elif topic == "/own":
            if time_ns >= self._pose_due_ns:
                self._pose_due_ns = time_ns + _POSE_PERIOD_NS
                self._log_pose(orjson.loads(payload), time_ns)
            if time_ns >= self._scene_due_ns:
                self._log_scene(time_ns)
                self._scene_due_ns = time_ns + _SCENE_PERIOD_NS

    def _log_event(self, event: dict[str, Any], time_ns: int) -> None:
        level = _LEVELS.get(event["level"], fx.LogLevel.Unknown)
        self._log.log(fx.Log(timestamp=_stamp(time_ns), level=level, message=event["text"], name=event["name"]), log_time=time_ns)

    def _log_pose(self, own: dict[str, Any], time_ns: int) -> None:
        half = (math.pi / 2 - own["yaw_rad"]) / 2
        pose = fx.Pose(
            position=_enu(own["position_ned_m"]), orientation=fx.Quaternion(x=0, y=0, z=math.sin(half), w=math.cos(half))
        )
        self._pose.log(fx.PoseInFrame(timestamp=_stamp(time_ns), frame_id=FRAME, pose=pose), log_time=time_ns)

    def _log_scene(self, time_ns: int) -> None:
        stamp = _stamp(time_ns)
        entities = []
        if self._scene_due_ns == 0 and self._mission is not None:
            entities.append(_surroundings(self._mission, stamp))
        if "/obstacles" in self._latest:
            discs = [_disc(row) for row in orjson.loads(self._latest.pop("/obstacles"))["discs"]]
            entities.append(fx.SceneEntity(timestamp=stamp, frame_id=FRAME, id="discs", cylinders=discs))
        if "/target" in self._latest:
            target = orjson.loads(self._latest.pop("/target"))
            ball = fx.SpherePrimitive(
                pose=fx.Pose(position=_enu(target["position_ned_m"]), orientation=_UPRIGHT),
                size=fx.Vector3(x=0.7, y=0.7, z=0.7),
                color=_RED,
            )
            entities.append(fx.SceneEntity(timestamp=stamp, frame_id=FRAME, id="target", spheres=[ball]))
        if entities:
            self._scene.log(fx.SceneUpdate(entities=entities), log_time=time_ns)


_UPRIGHT = fx.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)


def _stamp(time_ns: int) -> fx.Timestamp:
    return fx.Timestamp(sec=time_ns // 1_000_000_000, nsec=time_ns % 1_000_000_000)


def _enu(ned_m: Sequence[float]) -> fx.Vector3:
    return fx.Vector3(x=ned_m[1], y=ned_m[0], z=-ned_m[2])


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
        pose=fx.Pose(position=centre, orientation=_UPRIGHT), size=size, bottom_scale=1.0, top_scale=1.0, color=color
    )


def _surroundings(mission: Mission, stamp: fx.Timestamp) -> fx.SceneEntity:
    """Protected boundary (red), fence (blue) and surveyed obstacles (grey)."""
    height_m = mission.height_m
    cylinders = [_cylinder(c.north_m, c.east_m, c.radius_m, 0.0, c.height_m, _GREY) for c in mission.obstacles.cylinders]
    cubes = []
    for box in mission.obstacles.boxes:
        half = (math.pi / 2 - math.radians(box.heading_deg)) / 2
        turn = fx.Quaternion(x=0, y=0, z=math.sin(half), w=math.cos(half))
        centre = fx.Vector3(x=box.east_m, y=box.north_m, z=box.height_m / 2)
        size = fx.Vector3(x=box.length_m, y=box.width_m, z=box.height_m)
        cubes.append(fx.CubePrimitive(pose=fx.Pose(position=centre, orientation=turn), size=size, color=_GREY))
    lines = [
        _line(mission.boundary.vertices_m, mission.boundary.closed, height_m, _RED),
        _line(mission.flight_volume.vertices_m, True, height_m, _BLUE),
    ]
    return fx.SceneEntity(timestamp=stamp, frame_id=FRAME, id="mission", lines=lines, cylinders=cylinders, cubes=cubes)


def _line(vertices_m: Sequence[tuple[float, float]], closed: bool, height_m: float, color: fx.Color) -> fx.LinePrimitive:
    kind = fx.LinePrimitiveLineType.LineLoop if closed else fx.LinePrimitiveLineType.LineStrip
    points = [fx.Point3(x=east_m, y=north_m, z=height_m) for north_m, east_m in vertices_m]
    return fx.LinePrimitive(type=kind, thickness=0.08, points=points, color=color)
