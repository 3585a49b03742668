"""What makes a recording open usefully in Foxglove: poses, scene, place and log in its well-known schemas."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import foxglove.messages as fx
import numpy as np
import orjson

from flightapp.config.mission import Mission
from flightapp.core.geodesy import mission_to_geodetic
from flightapp.recording import drawing

POSE, TEAM, LOCATION, SCENE, LOG = "/view/pose", "/view/team", "/view/location", "/view/scene", "/log"
_PERIODS_NS = {POSE: 100_000_000, TEAM: 200_000_000, LOCATION: 500_000_000, SCENE: 200_000_000}
_SURROUNDINGS_PERIOD_NS = 5_000_000_000
"""They never change; whoever connects to the live view later sees them all the same."""
_PATHS_FADE_NS = 1_000_000_000
_DRAWN = ("/target", "/obstacles", "/decision", "/team", "/candidates")
_LEVELS = {"info": fx.LogLevel.Info, "warning": fx.LogLevel.Warning, "error": fx.LogLevel.Error}

Draw = Callable[[str, Any, int], None]


class View:
    """Derives the view from recorded messages, at a rate that people see; one instance a recording.

    draw: takes topic, message and time, ns. is_wanted: asked before the work is done, whether it is to be done for a topic.
    """

    def __init__(self, draw: Draw, is_wanted: Callable[[str], bool], mission: Mission | None) -> None:
        self._draw = draw
        self._is_wanted = is_wanted
        self._mission = mission
        self._datum = None if mission is None else mission.datum.as_point()
        self._due_ns: dict[str, int] = {}
        self._surroundings_due_ns = 0
        self._paths_end_ns: int | None = None
        self._latest: dict[str, bytes] = {}

    def feed(self, topic: str, payload: bytes, time_ns: int) -> None:
        """Take note of one recorded message and draw what follows from it."""
        if topic == "/event":
            if self._is_wanted(LOG):
                self._draw_event(orjson.loads(payload), time_ns)
        elif topic == "/own":
            self._draw_own(payload, time_ns)
            if self._is_due(SCENE, time_ns):
                self._draw_scene(time_ns)
        elif topic in _DRAWN:
            self._latest[topic] = payload
            if topic == "/team" and self._is_due(TEAM, time_ns):
                self._draw_team(orjson.loads(payload), time_ns)

    def _is_due(self, topic: str, time_ns: int) -> bool:
        if time_ns < self._due_ns.get(topic, 0) or not self._is_wanted(topic):
            return False
        self._due_ns[topic] = time_ns + _PERIODS_NS[topic]
        return True

    def _draw_event(self, event: Mapping[str, Any], time_ns: int) -> None:
        level = _LEVELS.get(event["level"], fx.LogLevel.Unknown)
        line = fx.Log(timestamp=drawing.stamp_of(time_ns), level=level, message=event["text"], name=event["name"])
        self._draw(LOG, line, time_ns)

    def _draw_own(self, payload: bytes, time_ns: int) -> None:
        pose_is_due, place_is_due = self._is_due(POSE, time_ns), self._datum is not None and self._is_due(LOCATION, time_ns)
        if not pose_is_due and not place_is_due:
            return
        own, stamp = orjson.loads(payload), drawing.stamp_of(time_ns)
        place = own["position_ned_m"]
        if pose_is_due:
            pose = fx.Pose(position=drawing.enu(place), orientation=drawing.turned(own["yaw_rad"]))
            self._draw(POSE, fx.PoseInFrame(timestamp=stamp, frame_id=drawing.FRAME, pose=pose), time_ns)
        if place_is_due:
            assert self._datum is not None
            point = mission_to_geodetic(self._datum, np.array(place))
            fix = fx.LocationFix(
                timestamp=stamp, latitude=point.latitude_deg, longitude=point.longitude_deg, altitude=point.altitude_m
            )
            self._draw(LOCATION, fix, time_ns)

    def _draw_team(self, team: Mapping[str, Any], time_ns: int) -> None:
        poses = []
        for member in team["members"]:
            north_m_s, east_m_s, _ = member["velocity_ned_m_s"]
            course = drawing.turned(math.atan2(east_m_s, north_m_s))
            poses.append(fx.Pose(position=drawing.enu(member["position_ned_m"]), orientation=course))
        message = fx.PosesInFrame(timestamp=drawing.stamp_of(time_ns), frame_id=drawing.FRAME, poses=poses)
        self._draw(TEAM, message, time_ns)

    def _draw_scene(self, time_ns: int) -> None:
        stamp = drawing.stamp_of(time_ns)
        entities = []
        if self._mission is not None and time_ns >= self._surroundings_due_ns:
            self._surroundings_due_ns = time_ns + _SURROUNDINGS_PERIOD_NS
            entities.append(drawing.surroundings(self._mission, stamp))
        height_m = 0.0 if self._mission is None else self._mission.height_m
        latest = {topic: orjson.loads(payload) for topic, payload in self._latest.items()}
        self._latest.clear()
        if "/obstacles" in latest:
            entities.append(drawing.discs(latest["/obstacles"], stamp))
        if "/target" in latest:
            entities.append(drawing.target(latest["/target"], stamp))
        if "/team" in latest:
            entities.append(drawing.teammates(latest["/team"], stamp))
        if "/decision" in latest:
            entities.append(drawing.intent(latest["/decision"], height_m, stamp))
        if "/candidates" in latest:
            entities.append(drawing.paths(latest["/candidates"], stamp))
            self._paths_end_ns = time_ns + _PATHS_FADE_NS
        elif self._paths_end_ns is not None and time_ns >= self._paths_end_ns:
            entities.append(drawing.nothing("paths", stamp))
            self._paths_end_ns = None
        if entities:
            self._draw(SCENE, fx.SceneUpdate(entities=entities), time_ns)
