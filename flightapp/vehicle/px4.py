"""PX4 over MAVSDK 4: the synchronous plug-ins with callbacks into latest-value slots.

MAVSDK runs every callback on one native thread. Commands are asynchronous with a completion callback, so neither the
event loop nor the default executor ever waits for the autopilot in flight.
"""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any

import mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.info import Info
from mavsdk.plugins.offboard import Offboard

from flightapp.config.profile import Autopilot as AutopilotConfig
from flightapp.core.clock import Clock
from flightapp.core.geodesy import GeodeticPoint
from flightapp.core.types import Setpoint
from flightapp.vehicle.autopilot import Accuracy, AutopilotDetails, BatteryState, HealthState, Motion, Status
from flightapp.vehicle.commands import Commands
from flightapp.vehicle.connection import Connection
from flightapp.vehicle.parameters import Parameters
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.setpoints import Setpoints
from flightapp.vehicle.telemetry import TelemetrySlots

VERSION_TIMEOUT_S = 3.0
VERSION_PERIOD_S = 0.1


class Px4:
    """One PX4, identified by its system id."""

    def __init__(
        self,
        config: AutopilotConfig,
        system_id: int,
        datum: GeodeticPoint,
        clock: Clock,
        history: PoseHistory,
        *,
        acceleration_feed_forward: bool = False,
    ) -> None:
        self._config = config
        self._system_id = system_id
        self._clock = clock
        self._acceleration_feed_forward = acceleration_feed_forward
        self._connection = Connection(config, system_id, clock)
        self._telemetry = TelemetrySlots(system_id, datum, clock, history)
        self._commands = Commands(clock, self._telemetry.complaints)
        self._version: tuple[int, int, int] | None = None
        self._hardware_uid = ""

    async def connect(self) -> str:
        system = await self._connection.open()
        self._action = Action(system)
        self._offboard = Offboard(system)
        self._parameters = Parameters(system)
        self._setpoints = Setpoints(self._offboard, self._acceleration_feed_forward)
        self._telemetry.subscribe(system)
        await self._telemetry.set_rates(self._commands, self._config.telemetry_rate_hz)
        self._telemetry.request_origin()
        return await self._describe(system)

    def motion(self) -> Motion | None:
        return self._telemetry.motion

    def status(self) -> Status:
        self._telemetry.request_origin()
        return self._telemetry.status()

    def battery(self) -> BatteryState | None:
        return self._telemetry.battery

    def health(self) -> HealthState:
        return HealthState(*self._telemetry.healthy, origin_known=self._telemetry.origin_known)

    def accuracy(self) -> Accuracy | None:
        return self._telemetry.accuracy()

    def details(self) -> AutopilotDetails:
        now_s, telemetry = self._clock.now_s(), self._telemetry
        return AutopilotDetails(
            autopilot=telemetry.autopilot,
            version=self._version,
            hardware_uid=self._hardware_uid,
            system_ids_heard=self._connection.system_ids_heard(),
            twin=telemetry.twin(now_s),
            state_rate_hz=telemetry.state_rate.rate_hz(now_s),
            attitude_rate_hz=telemetry.attitude_rate.rate_hz(now_s),
            accuracy=telemetry.accuracy(),
            home_ned_m=telemetry.home_ned_m(),
            transmitter_seen=telemetry.transmitter_seen,
            telemetry_gap_s=max(telemetry.state_rate.gap_max_s(now_s), telemetry.attitude_rate.gap_max_s(now_s)),
        )

    async def set_heights(self, takeoff_m: float, return_m: float) -> None:
        action, run = self._action, self._commands.run
        await run("set the take-off height", lambda done: action.set_takeoff_altitude_async(takeoff_m, done))
        await run("set the return height", lambda done: action.set_return_to_launch_altitude_async(return_m, done))
        await self.set_parameter("RTL_CONE_ANG", 0, is_integer=True)

    async def parameter(self, name: str, *, is_integer: bool) -> float | None:
        return await self._parameters.read(name, is_integer=is_integer)

    async def set_parameter(self, name: str, value: float, *, is_integer: bool) -> None:
        await self._parameters.write(name, value, is_integer=is_integer)

    async def arm(self) -> None:
        await self._commands.run("arm", self._action.arm_async)

    async def disarm(self) -> None:
        await self._commands.run("disarm", self._action.disarm_async)

    async def takeoff(self) -> None:
        await self._commands.run("take off", self._action.takeoff_async)

    async def start_offboard(self) -> None:
        await self._commands.run("OFFBOARD", self._offboard.start_async)

    def send(self, setpoint: Setpoint) -> None:
        self._setpoints.send(setpoint)

    async def return_to_launch(self) -> None:
        await self._commands.run("return", self._action.return_to_launch_async)

    async def land(self) -> None:
        await self._commands.run("land", self._action.land_async)

    async def terminate(self) -> None:
        await self._commands.run("terminate", self._action.terminate_async)

    def take_status_texts(self) -> list[tuple[float, str, str]]:
        return self._telemetry.take_texts()

    def close(self) -> None:
        self._connection.close()

    async def _describe(self, system: Any) -> str:
        """What the autopilot says of itself; MAVSDK asks for it by itself and has it a moment after discovery."""
        info = Info(system)
        deadline_s = self._clock.now_s() + VERSION_TIMEOUT_S
        while True:
            try:
                version = info.get_version()
            except mavsdk.MavsdkError as error:
                if self._clock.now_s() > deadline_s:
                    return f"system {self._system_id}, version unknown ({error})"
                await asyncio.sleep(VERSION_PERIOD_S)
                continue
            self._version = (version.flight_sw_major, version.flight_sw_minor, version.flight_sw_patch)
            with contextlib.suppress(mavsdk.MavsdkError):
                self._hardware_uid = str(info.get_identification().hardware_uid)
            number = f"{version.flight_sw_major}.{version.flight_sw_minor}.{version.flight_sw_patch}"
            return f"system {self._system_id}, autopilot {number}"
