"""The app's view of an autopilot, over the mock's own MAVLink on the virtual clock. What `vehicle.px4` is over MAVSDK.

It keeps MAVSDK's habits that matter for safety: the last setpoint is repeated at 20 Hz until another mode is reported, an
unanswered command times out, news of mode and arming come with heartbeats only.
"""

from __future__ import annotations

import asyncio
import math
from collections import deque
from typing import Any

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.clock import Clock
from flightapp.core.errors import FlightError
from flightapp.core.geodesy import GeodeticPoint, geodetic_to_mission, px4_local_to_geodetic
from flightapp.core.types import Setpoint, VehicleState
from flightapp.sim.autopilot_modes import Mode, mode_of
from flightapp.sim.mavlink_dialect import mavlink
from flightapp.sim.mavlink_io import Station
from flightapp.vehicle.autopilot import Accuracy, AutopilotDetails, BatteryState, HealthState, Motion, Status
from flightapp.vehicle.boot_clock import BootClock
from flightapp.vehicle.pose_history import PoseHistory

ANSWER_S = 2.0
REPEAT_S = 0.05
STARTING_S = 1.5
"""So long after the wish for OFFBOARD a heartbeat with another mode does not end the repeats."""
CONNECTION_LOST_S = 3.0
VELOCITY_AND_YAW = 2503
POSITION_VELOCITY_ACCELERATION_AND_YAW = 2048
"""As MAVSDK sends an acceleration: with a position of NaN."""
ORDERS = (
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_DO_SET_MODE,
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_NAV_LAND,
    mavlink.MAV_CMD_DO_FLIGHTTERMINATION,
)
"""Commands that arm, disarm or change the mode."""
TELEMETRY_HZ = 50.0
MODE_NAMES = {Mode.RTL: "RETURN_TO_LAUNCH"}
LANDED_NAMES = {0: "UNKNOWN", 1: "ON_GROUND", 2: "IN_AIR", 3: "TAKING_OFF", 4: "LANDING"}
POSITION_SENSOR = mavlink.MAV_SYS_STATUS_SENSOR_GPS
SEVERITIES = ("EMERGENCY", "ALERT", "CRITICAL", "ERROR", "WARNING", "NOTICE", "INFO", "DEBUG")


class VirtualAutopilot:
    """One vehicle's autopilot behind `station`. `receive` takes what the station sends."""

    def __init__(self, station: Station, system_id: int, datum: GeodeticPoint, clock: Clock, history: PoseHistory) -> None:
        self._station, self._system_id, self._datum = station, system_id, datum
        self._clock, self._history = clock, history
        self._packer = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=191)
        self._parser = mavlink.MAVLink(None)
        self._parser.robust_parsing = True
        self._boot_clock = BootClock()
        self._origin: GeodeticPoint | None = None
        self._attitude: tuple[float, float, float] | None = None
        self._motion: Motion | None = None
        self._battery: BatteryState | None = None
        self._mode, self._landed, self._armed = "UNKNOWN", "UNKNOWN", False
        self._heartbeat_s = -math.inf
        self._healthy = 0
        self._home: tuple[float, float, float] | None = None
        self._accuracy: Accuracy | None = None
        self._version: tuple[int, int, int] | None = None
        self._texts: deque[tuple[float, str, str]] = deque(maxlen=200)
        self._waiting: dict[tuple[str, object], asyncio.Future[Any]] = {}
        self._setpoint: bytes | None = None
        self._setpoint_s = -math.inf
        self._offboard_asked_s = -math.inf
        self.sent: list[tuple[float, Setpoint]] = []
        """Every setpoint of the app with its time: for what is checked afterwards."""
        self.commanded: list[tuple[float, str]] = []
        """Every command of the app with its time."""
        self.transmitted_s: list[float] = []
        """When a setpoint went out, repeats included."""
        self.commands: list[tuple[float, str]] = []
        """Every command to arm or to change the mode, by what it wants, with its time."""

    def receive(self, packet: bytes) -> None:
        """Bytes from the autopilot."""
        for message in self._parser.parse_buffer(packet) or ():
            handler = getattr(self, f"_on_{message.get_type().lower()}", None)
            if handler is not None and message.get_srcSystem() == self._system_id:
                handler(message)

    def repeat(self) -> None:
        """Called often: MAVSDK's own 20 Hz, from a thread that lives on while the app hangs."""
        now_s = self._clock.now_s()
        if self._setpoint is not None and now_s - self._setpoint_s >= REPEAT_S:
            self._setpoint_s = now_s
            self._transmit_setpoint(self._setpoint)

    def silence(self) -> None:
        """The process has died: nothing is repeated any more."""
        self._setpoint = None

    async def connect(self) -> str:
        deadline_s = self._clock.now_s() + 20.0
        while not math.isfinite(self._heartbeat_s):
            if self._clock.now_s() > deadline_s:
                raise FlightError(f"no autopilot with system id {self._system_id} within 20 s; heard nothing at all")
            await asyncio.sleep(0.05)
        interval_us = 1e6 / TELEMETRY_HZ
        for number in (mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, mavlink.MAVLINK_MSG_ID_ATTITUDE):
            await self._command("set a rate", mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, number, interval_us)
        for number in (mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION):
            await self._command("ask for a message", mavlink.MAV_CMD_REQUEST_MESSAGE, number)
        return f"system {self._system_id}, virtual"

    def motion(self) -> Motion | None:
        return self._motion

    def status(self) -> Status:
        connected = self._clock.now_s() - self._heartbeat_s < CONNECTION_LOST_S
        return Status(connected, self._mode, self._armed, self._landed, self._heartbeat_s)

    def battery(self) -> BatteryState | None:
        return self._battery

    def health(self) -> HealthState:
        if self._origin is None:
            self._request(mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN)
        position = bool(self._healthy & POSITION_SENSOR)
        armable = bool(self._healthy & mavlink.MAV_SYS_STATUS_PREARM_CHECK)
        return HealthState(position, self._home is not None, armable, origin_known=self._origin is not None)

    def accuracy(self) -> Accuracy | None:
        return self._accuracy

    def details(self) -> AutopilotDetails:
        return AutopilotDetails(
            autopilot="PX4",
            version=self._version,
            hardware_uid="",
            system_ids_heard=(self._system_id,),
            twin="",
            state_rate_hz=TELEMETRY_HZ if self._motion is not None else 0.0,
            attitude_rate_hz=TELEMETRY_HZ if self._attitude is not None else 0.0,
            accuracy=self._accuracy,
            home_ned_m=self._home,
            transmitter_seen=None,
        )

    async def set_heights(self, takeoff_m: float, return_m: float) -> None:
        await self.set_parameter("MIS_TAKEOFF_ALT", takeoff_m, is_integer=False)
        await self.set_parameter("RTL_RETURN_ALT", return_m, is_integer=False)
        await self.set_parameter("RTL_CONE_ANG", 0, is_integer=True)

    async def parameter(self, name: str, *, is_integer: bool) -> float | None:  # noqa: ARG002
        parameters = self._station.core.parameters
        return float(parameters[name]) if name in parameters else None

    async def set_parameter(self, name: str, value: float, *, is_integer: bool) -> None:
        self._station.core.parameters[name] = int(value) if is_integer else float(value)

    async def arm(self) -> None:
        await self._command("arm", mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    async def disarm(self) -> None:
        await self._command("disarm", mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)

    async def takeoff(self) -> None:
        await self._command("take off", mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, math.nan, math.nan, math.nan, math.nan)

    async def start_offboard(self) -> None:
        main, sub = Mode.OFFBOARD.value
        self._offboard_asked_s = self._clock.now_s()
        await self._command("OFFBOARD", mavlink.MAV_CMD_DO_SET_MODE, 1, main, sub)

    async def return_to_launch(self) -> None:
        await self._command("return", mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)

    async def land(self) -> None:
        await self._command("land", mavlink.MAV_CMD_NAV_LAND)

    async def terminate(self) -> None:
        await self._command("terminate", mavlink.MAV_CMD_DO_FLIGHTTERMINATION, 1)

    def send(self, setpoint: Setpoint) -> None:
        north, east, down = (float(value) for value in setpoint.velocity_ned_m_s)
        if not math.isfinite(north + east + down + setpoint.yaw_rad):
            raise ValueError(f"setpoint is not finite: velocity {(north, east, down)} m/s, yaw {setpoint.yaw_rad} rad")
        now_s = self._clock.now_s()
        self.sent.append((now_s, setpoint))
        fed_forward = setpoint.acceleration_ned_m_s2
        place, mask = 0.0, VELOCITY_AND_YAW
        pushes = [0.0, 0.0, 0.0]
        if fed_forward is not None:
            place, mask, pushes = math.nan, POSITION_VELOCITY_ACCELERATION_AND_YAW, fed_forward.tolist()
        message = mavlink.MAVLink_set_position_target_local_ned_message(
            *(0, self._system_id, 1, mavlink.MAV_FRAME_LOCAL_NED, mask),
            *(place, place, place, north, east, down, *pushes, setpoint.yaw_rad, 0),
        )
        self._setpoint, self._setpoint_s = message.pack(self._packer), now_s
        self._transmit_setpoint(self._setpoint)

    def take_status_texts(self) -> list[tuple[float, str, str]]:
        texts = list(self._texts)
        self._texts.clear()
        return texts

    def close(self) -> None:
        self.silence()

    def _transmit_setpoint(self, packet: bytes) -> None:
        self.transmitted_s.append(self._clock.now_s())
        self._transmit(packet)

    def _transmit(self, packet: bytes) -> None:
        self._packer.seq = (self._packer.seq + 1) % 256
        self._station.receive(packet)
        for answer in self._station.answers():
            self.receive(answer)

    def _request(self, number: int) -> None:
        values = (float(number), 0, 0, 0, 0, 0, 0)
        command = mavlink.MAV_CMD_REQUEST_MESSAGE
        self._transmit(mavlink.MAVLink_command_long_message(self._system_id, 1, command, 0, *values).pack(self._packer))

    async def _command(self, what: str, command: int, *values: float) -> None:
        parameters = (*values, *(0.0,) * (7 - len(values)))
        if command in ORDERS:
            self.commands.append((self._clock.now_s(), what))
        self.commanded.append((self._clock.now_s(), what))
        answer = asyncio.get_running_loop().create_future()
        self._waiting["COMMAND_ACK", command] = answer
        self._transmit(mavlink.MAVLink_command_long_message(self._system_id, 1, command, 0, *parameters).pack(self._packer))
        try:
            result = await asyncio.wait_for(answer, ANSWER_S)
        except TimeoutError:
            raise FlightError(f"autopilot gave no answer to '{what}' within {ANSWER_S:g} s") from None
        if result != mavlink.MAV_RESULT_ACCEPTED:
            raise FlightError(f"autopilot refused '{what}': MAV_RESULT {result}")

    def _on_command_ack(self, message: Any) -> None:
        answer = self._waiting.pop(("COMMAND_ACK", message.command), None)
        if answer is not None and not answer.done():
            answer.set_result(message.result)

    def _on_heartbeat(self, message: Any) -> None:
        mode = mode_of(message.custom_mode >> 16 & 0xFF, message.custom_mode >> 24 & 0xFF)
        self._mode = "UNKNOWN" if mode is None else MODE_NAMES.get(mode, mode.name)
        self._armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        self._heartbeat_s = self._clock.now_s()
        if mode is not Mode.OFFBOARD and self._heartbeat_s - self._offboard_asked_s > STARTING_S:
            self._setpoint = None

    def _on_attitude(self, message: Any) -> None:
        if math.isfinite(message.roll + message.pitch + message.yaw):
            t_s = self._boot_clock.to_fleet_s(message.time_boot_ms * 1e-3, self._clock.now_s())
            self._attitude = (message.roll, message.pitch, message.yaw)
            self._history.append_attitude(t_s, message.roll, message.pitch, wrap_pi(message.yaw))

    def _on_local_position_ned(self, message: Any) -> None:
        if self._origin is None or self._attitude is None:
            return
        now_s = self._clock.now_s()
        local = np.array([message.x, message.y, message.z], dtype=np.float64)
        velocity = np.array([message.vx, message.vy, message.vz], dtype=np.float64)
        if not (np.isfinite(local).all() and np.isfinite(velocity).all()):
            return
        t_s = self._boot_clock.to_fleet_s(message.time_boot_ms * 1e-3, now_s)
        position = geodetic_to_mission(self._datum, px4_local_to_geodetic(self._origin, local))
        roll, pitch, yaw = self._attitude
        state = VehicleState(t_s, position, velocity, wrap_pi(yaw))
        self._history.append_state(state)
        self._motion = Motion(state, roll, pitch, now_s)

    def _on_gps_global_origin(self, message: Any) -> None:
        self._origin = GeodeticPoint(message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3)

    def _on_home_position(self, message: Any) -> None:
        point = GeodeticPoint(message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3)
        north, east, down = geodetic_to_mission(self._datum, point).tolist()
        self._home = (north, east, down)

    def _on_gps_raw_int(self, message: Any) -> None:
        self._accuracy = Accuracy(message.satellites_visible, message.fix_type, math.nan, math.nan)

    def _on_sys_status(self, message: Any) -> None:
        self._healthy = message.onboard_control_sensors_health

    def _on_extended_sys_state(self, message: Any) -> None:
        self._landed = LANDED_NAMES.get(message.landed_state, "UNKNOWN")

    def _on_battery_status(self, message: Any) -> None:
        cells = [value for value in message.voltages if value != 65535]
        self._battery = BatteryState(sum(cells) * 1e-3, message.battery_remaining / 100.0)

    def _on_autopilot_version(self, message: Any) -> None:
        number = message.flight_sw_version
        self._version = (number >> 24 & 0xFF, number >> 16 & 0xFF, number >> 8 & 0xFF)

    def _on_statustext(self, message: Any) -> None:
        severity = SEVERITIES[min(message.severity, len(SEVERITIES) - 1)]
        self._texts.append((self._clock.now_s(), severity, message.text))
