"""The one table of recorded channels. Recorder, small log, live view, health checks and reader all work from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import foxglove.messages as fx

from flightapp.recording import messages


class Priority(IntEnum):
    """What is given up when the disk is slow or full, cheapest first."""

    IMAGE = 0
    VIEW = 1
    """Drawn from other channels: nothing is lost that the recording does not hold."""
    DIAGNOSTICS = 2
    SURROUNDINGS = 3
    STATE = 4
    ESSENTIAL = 5
    """What was commanded, and the story."""


ALL = math.inf
"""As `small_hz`: every message."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel of a recording.

    message: a dataclass (written as JSON), or one of Foxglove's own messages (written as Protobuf under its well-known name).
    rate_hz: expected while airborne; 0: on events or by choice.
    small_hz: at most so many messages a second are in the small log; 0: none, ALL: every one.
    logged, live: whether it is in the file, and whether the live view has it.
    """

    topic: str
    message: type
    rate_hz: float
    priority: Priority
    small_hz: float
    purpose: str
    logged: bool = True
    live: bool = True


CHANNELS: tuple[Channel, ...] = (
    Channel("/own", messages.OwnState, 25.0, Priority.STATE, 2.0, "own state in the control loop"),
    Channel("/autopilot", messages.AutopilotStatus, 1.0, Priority.STATE, 1.0, "mode, arming and landed state of the autopilot"),
    Channel("/battery", messages.Battery, 0.5, Priority.STATE, 0.2, "battery"),
    Channel("/target", messages.Target, 25.0, Priority.SURROUNDINGS, 2.0, "target estimate given to the planner"),
    Channel("/sighting", messages.TargetSighting, 0.0, Priority.SURROUNDINGS, 1.0, "measurements of the target, used or not"),
    Channel("/team", messages.Team, 10.0, Priority.SURROUNDINGS, 1.0, "teammates as known here"),
    Channel(
        "/obstacles", messages.Obstacles, 25.0, Priority.SURROUNDINGS, 0.5, "discs and unseen sectors after each depth frame"
    ),
    Channel("/decision", messages.DecisionRecord, 25.0, Priority.STATE, 2.0, "planner decision"),
    Channel("/candidates", messages.Candidates, 0.0, Priority.DIAGNOSTICS, 0.0, "paths that the dynamic window weighed, 5 Hz"),
    Channel("/setpoint", messages.SetpointRecord, 25.0, Priority.ESSENTIAL, 2.0, "setpoint after the supervisor, as sent"),
    Channel("/event", messages.Event, 0.0, Priority.ESSENTIAL, ALL, "events"),
    Channel("/phase", messages.Phase, 0.0, Priority.ESSENTIAL, ALL, "mission phase and outcome"),
    Channel("/health", messages.Health, 1.0, Priority.STATE, 1.0, "CPU, memory, lateness, the recorder itself"),
    Channel("/clocks", messages.ClockOffsets, 0.0, Priority.ESSENTIAL, ALL, "measured offsets of the other vehicles' clocks"),
    Channel("/observation", messages.ObservationRecord, 0.0, Priority.DIAGNOSTICS, 0.0, "what planner and supervisor were given"),
    Channel("/plan", messages.TeamPlan, 0.0, Priority.STATE, 1.0, "who closes in from which side, by the leader's plan in force"),
    Channel("/way", messages.Way, 0.0, Priority.STATE, ALL, "planned ways past known obstacles: ingress, out of traps, home"),
    Channel(
        "/truth",
        messages.TruthRecord,
        0.0,
        Priority.STATE,
        0.0,
        "true states, in the simulation's own recording only",
        live=False,
    ),
    Channel("/depth", fx.CompressedImage, 0.0, Priority.IMAGE, 0.0, "depth image, 16-bit PNG, at recording.depth_rate_hz"),
    Channel("/depth/calibration", fx.CameraCalibration, 0.0, Priority.IMAGE, 0.0, "intrinsics of that depth image"),
    Channel("/depth/info", messages.DepthInfo, 0.0, Priority.IMAGE, 0.0, "unit, pose and mounting of that depth image"),
    Channel("/view/pose", fx.PoseInFrame, 0.0, Priority.VIEW, 0.0, "own pose, 10 Hz"),
    Channel("/view/team", fx.PosesInFrame, 0.0, Priority.VIEW, 0.0, "poses of the other vehicles, 5 Hz"),
    Channel("/view/location", fx.LocationFix, 0.0, Priority.VIEW, 0.0, "own place on the globe for the map, 2 Hz"),
    Channel(
        "/view/scene", fx.SceneUpdate, 0.0, Priority.VIEW, 0.0, "fence, boundary, discs, target, Apollonius sets, paths, 5 Hz"
    ),
    Channel("/log", fx.Log, 0.0, Priority.VIEW, ALL, "events as log lines"),
)
