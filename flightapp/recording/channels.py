"""The one table of recorded channels. Recorder, live view, health checks and reader all work from it."""

from __future__ import annotations

from dataclasses import dataclass

import foxglove.messages as fx

from flightapp.recording import messages


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel: topic, message type, expected rate while airborne (0: on events or by choice), recorded?, live?

    message: a dataclass (written as JSON), or one of Foxglove's own messages (written as Protobuf under its well-known name).
    """

    topic: str
    message: type
    rate_hz: float
    logged: bool
    live: bool
    purpose: str


CHANNELS: tuple[Channel, ...] = (
    Channel("/own", messages.OwnState, 25.0, True, True, "own state in the control loop"),
    Channel("/autopilot", messages.AutopilotStatus, 1.0, True, True, "mode, arming and landed state of the autopilot"),
    Channel("/battery", messages.Battery, 0.5, True, True, "battery"),
    Channel("/target", messages.Target, 25.0, True, True, "target estimate given to the planner"),
    Channel("/sighting", messages.TargetSighting, 0.0, True, True, "measurements of the target, used or not"),
    Channel("/team", messages.Team, 10.0, True, True, "teammates as known here"),
    Channel("/obstacles", messages.Obstacles, 25.0, True, True, "discs and unseen sectors after each depth frame"),
    Channel("/decision", messages.DecisionRecord, 25.0, True, True, "planner decision"),
    Channel("/setpoint", messages.SetpointRecord, 25.0, True, True, "setpoint after the supervisor, as sent"),
    Channel("/event", messages.Event, 0.0, True, True, "events"),
    Channel("/phase", messages.Phase, 0.0, True, True, "mission phase and outcome"),
    Channel("/health", messages.Health, 1.0, True, True, "CPU, memory, lateness, drops"),
    Channel("/clocks", messages.ClockOffsets, 0.0, True, True, "measured offsets of the other vehicles' clocks"),
    Channel("/observation", messages.ObservationRecord, 0.0, True, False, "what planner and supervisor were given, for replay"),
    Channel("/plan", messages.TeamPlan, 0.0, True, True, "who closes in from which side, by the leader's plan in force"),
    Channel("/truth", messages.TruthRecord, 0.0, True, False, "true states, in the simulation's own recording only"),
    Channel("/depth", fx.CompressedImage, 0.0, True, True, "depth image, 16-bit PNG, at recording.depth_rate_hz"),
    Channel("/depth/calibration", fx.CameraCalibration, 0.0, True, True, "intrinsics of that depth image"),
    Channel("/depth/info", messages.DepthInfo, 0.0, True, True, "unit, pose and mounting of that depth image"),
)
