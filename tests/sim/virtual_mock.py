"""The whole mock on a virtual clock: no socket, no process; commands in as MAVLink bytes, messages out as MAVLink."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flightapp.config.loading import validate
from flightapp.core.geodesy import GeodeticPoint
from flightapp.sim.autopilot_core import STEP_S
from flightapp.sim.autopilot_estimator import Noise
from flightapp.sim.autopilot_frames import Frames, displaced_origin
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.autopilot_parameters import Value
from flightapp.sim.fault_script import FaultScript
from flightapp.sim.mavlink_dialect import mavlink
from flightapp.sim.mock_autopilot import Setup, make_station
from flightapp.sim.multirotor import MultirotorLimits, Wind

DATUM = GeodeticPoint(47.3977, 8.5456, 488.0)
VELOCITY_AND_YAW = 2503
POSITION_AND_VELOCITY = 2496


class VirtualMock:
    """Flies a station step by step; an offboard setpoint given to `stream` is repeated at 50 Hz."""

    def __init__(
        self,
        *faults: dict[str, Any],
        parameters: dict[str, Value] | None = None,
        noise: Noise | None = None,
        wind: Wind | None = None,
        seed: int = 1,
        system_id: int = 1,
    ) -> None:
        script = validate(FaultScript, {"faults": list(faults)}, Path("scenario.toml"))
        self.events: list[dict[str, object]] = []
        setup = Setup(
            system_id=system_id,
            frames=Frames(DATUM, displaced_origin(DATUM, 50.0, 1)),
            position_ned_m=(3.0, -2.0, 0.0),
            heading_rad=0.5,
            limits=MultirotorLimits(),
            wind=Wind() if wind is None else wind,
            script=script,
            parameters={"MIS_TAKEOFF_ALT": 3.0, **(parameters or {})},
            noise=noise,
            seed=seed,
        )
        self.station, self.faults = make_station(setup, self.events.append)
        self.core = self.station.core
        self.sent = b""
        self.messages: list[Any] = []
        self.stream: Any = None
        self._packer = mavlink.MAVLink(None, srcSystem=245, srcComponent=191)
        self._parser = mavlink.MAVLink(None)
        self._parser.robust_parsing = True

    def step(self) -> None:
        if self.stream is not None and self.core.steps % 4 == 0:
            self.send(self.stream)
        for packet in self.station.step():
            self._take(packet)

    def run(self, duration_s: float) -> None:
        for _ in range(round(duration_s / STEP_S)):
            self.step()

    def run_until(self, holds: Callable[[], Any], limit_s: float = 30.0) -> float:
        """Virtual time at which `holds()` became true."""
        end_s = self.core.t_s + limit_s
        while self.core.t_s < end_s:
            if holds():
                return self.core.t_s
            self.step()
        raise AssertionError(f"not within {limit_s} s; mode {self.core.mode}, events {self.events[-5:]}")

    def send(self, message: Any) -> None:
        packet = message.pack(self._packer)
        self._packer.seq = (self._packer.seq + 1) % 256
        self.station.receive(packet)
        for answer in self.station.answers():
            self._take(answer)

    def command(self, command: int, *values: float, system_id: int | None = None, settle_s: float = 0.0) -> int | None:
        """The result of a COMMAND_LONG, None where no acknowledgement came (within `settle_s`)."""
        parameters = (*values, *(0.0,) * (7 - len(values)))
        target = self.core.parameters["MAV_SYS_ID"] if system_id is None else system_id
        before = len(self.messages)
        self.send(mavlink.MAVLink_command_long_message(int(target), 1, command, 0, *parameters))
        self.run(settle_s)
        acks = [m for m in self.messages[before:] if m.get_type() == "COMMAND_ACK" and m.command == command]
        return int(acks[0].result) if acks else None

    def arm(self, settle_s: float = 0.0) -> int | None:
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, settle_s=settle_s)

    def disarm(self, force: bool = False) -> int | None:
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196 if force else 0)

    def mode(self, mode: Mode, settle_s: float = 0.0) -> int | None:
        main, sub = mode.value
        return self.command(mavlink.MAV_CMD_DO_SET_MODE, 1, main, sub, settle_s=settle_s)

    def take_off(self) -> None:
        """Armed, climbed, in HOLD."""
        self.run(1.0)
        assert self.arm() == 0
        assert self.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, math.nan, math.nan, math.nan, math.nan) == 0
        self.run_until(lambda: self.core.mode is Mode.HOLD)

    def fly_offboard(self, north: float = 0.0, east: float = 0.0, down: float = 0.0, yaw: float = 0.0) -> None:
        self.stream = self.velocity(north, east, down, yaw)
        self.send(self.stream)
        assert self.mode(Mode.OFFBOARD) == 0

    @staticmethod
    def velocity(north: float, east: float, down: float, yaw: float = 0.0) -> Any:
        return mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, mavlink.MAV_FRAME_LOCAL_NED, VELOCITY_AND_YAW, 0, 0, 0, north, east, down, 0, 0, 0, yaw, 0
        )

    def newest(self, kind: str) -> Any:
        return next(message for message in reversed(self.messages) if message.get_type() == kind)

    def all(self, kind: str) -> list[Any]:
        return [message for message in self.messages if message.get_type() == kind]

    def texts(self) -> list[str]:
        return [message.text for message in self.all("STATUSTEXT")]

    def fault_events(self) -> list[str]:
        return [str(event["event"]) for event in self.events if str(event["event"]).startswith("fault_")]

    def _take(self, packet: bytes) -> None:
        self.sent += packet
        for message in self._parser.parse_buffer(packet) or ():
            self.messages.append(message)
