"""PX4 over MAVSDK 4: the synchronous plug-ins with callbacks into latest-value slots.

MAVSDK runs every callback on one native thread. Commands are asynchronous with a completion callback, so neither the
event loop nor the default executor ever waits for the autopilot. Positions are converted to the mission frame here.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
from collections import deque
from collections.abc import Callable
from typing import Any

import mavsdk
import numpy as np
from mavsdk import logging as mavsdk_logging
from mavsdk.plugins.action import Action
from mavsdk.plugins.info import Info
from mavsdk.plugins.mavlink_direct import MavlinkDirect
from mavsdk.plugins.offboard import Offboard, VelocityNedYaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FixType, FlightMode, LandedState, Telemetry

from flightapp.config.profile import Autopilot as AutopilotConfig
from flightapp.core.angles import wrap_pi
from flightapp.core.clock import Clock
from flightapp.core.errors import FlightError
from flightapp.core.geodesy import GeodeticPoint, geodetic_to_mission, px4_local_to_geodetic
from flightapp.core.types import Setpoint, VehicleState
from flightapp.vehicle.autopilot import Accuracy, AutopilotDetails, BatteryState, HealthState, Motion, Status
from flightapp.vehicle.boot_clock import BootClock
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.rate_meter import RateMeter
from flightapp.vehicle.twin_watch import TwinWatch

COMPANION_COMPONENT_ID = 191
AUTOPILOT_COMPONENT_ID = 1
AUTOPILOTS = {0: "generic", 3: "ArduPilot", 12: "PX4"}
"""MAVLink MAV_AUTOPILOT."""
CONNECTION_LOST_S = 3.0
COMMAND_TIMEOUT_S = 5.0
VERSION_TIMEOUT_S = 3.0
ORIGIN_PERIOD_S = 1.0
COMPLAINTS = ("WARNING", "ERROR", "CRITICAL", "ALERT", "EMERGENCY")
COMPLAINT_DELAY_S = 0.1
"""The reason of a refusal comes as a status text beside the acknowledgement."""
COMPLAINT_AGE_MAX_S = 3.0
UNKNOWN_PARAMETER = ("TIMEOUT", "DOES_NOT_EXIST", "NOT_FOUND", "PARAM_NOT_FOUND", "DOESNT_EXIST")
"""PX4 before 1.16 does not answer at all when asked for a parameter that it does not have."""


class Px4:
    """One PX4, identified by its system id."""

    def __init__(self, config: AutopilotConfig, system_id: int, datum: GeodeticPoint, clock: Clock, history: PoseHistory) -> None:
        self._config = config
        self._system_id = system_id
        self._datum = datum
        self._clock = clock
        self._history = history
        self._boot_clock = BootClock()
        self._attitude: tuple[float, float, float] | None = None
        self._origin: GeodeticPoint | None = None
        self._motion: Motion | None = None
        self._mode = "UNKNOWN"
        self._armed = False
        self._landed = "UNKNOWN"
        self._heartbeat_s = -math.inf
        self._battery: BatteryState | None = None
        self._health = (False, False, False)
        self._texts: deque[tuple[float, str, str]] = deque(maxlen=200)
        self._complaints: deque[tuple[float, str]] = deque(maxlen=10)
        self._origin_asked_s = -math.inf
        self._mavsdk: Any = None
        self._version: tuple[int, int, int] | None = None
        self._hardware_uid = ""
        self._autopilot = ""
        self._state_rate, self._attitude_rate = RateMeter(), RateMeter()
        self._twin = TwinWatch()
        self._fix: tuple[int, int] | None = None
        self._uncertainty_m = (math.nan, math.nan)
        self._home: GeodeticPoint | None = None
        self._transmitter_seen: bool | None = None

    async def connect(self) -> str:
        mavsdk_logging.log_subscribe(lambda _level, _message, _file, _line: True)
        configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.COMPANION_COMPUTER)
        configuration.system_id = self._system_id
        configuration.component_id = COMPANION_COMPONENT_ID
        self._mavsdk = mavsdk.Mavsdk(configuration)
        try:
            self._mavsdk.add_any_connection_with_handle(self._config.connection_url)
        except Exception as error:
            raise FlightError(
                f"autopilot link '{self._config.connection_url}' cannot be opened ({error}); "
                "check autopilot.connection_url in the profile"
            ) from None
        system = await self._find_system()
        self._telemetry = Telemetry(system)
        self._action = Action(system)
        self._offboard = Offboard(system)
        self._direct = MavlinkDirect(system)
        self._param = Param(system)
        self._subscribe()
        await self._set_rates()
        self._request_origin()
        return await self._describe(system)

    def motion(self) -> Motion | None:
        return self._motion

    def status(self) -> Status:
        connected = self._clock.now_s() - self._heartbeat_s < CONNECTION_LOST_S
        return Status(connected, self._mode, self._armed, self._landed, self._heartbeat_s)

    def battery(self) -> BatteryState | None:
        return self._battery

    def health(self) -> HealthState:
        if self._origin is None:
            self._request_origin()
        return HealthState(*self._health, origin_known=self._origin is not None)

    def details(self) -> AutopilotDetails:
        now_s = self._clock.now_s()
        home = None if self._home is None else geodetic_to_mission(self._datum, self._home)
        return AutopilotDetails(
            autopilot=self._autopilot,
            version=self._version,
            hardware_uid=self._hardware_uid,
            system_ids_heard=tuple(sorted({system.get_system_id() for system in self._mavsdk.get_systems()})),
            twin=self._twin.sign(now_s),
            state_rate_hz=self._state_rate.rate_hz(now_s),
            attitude_rate_hz=self._attitude_rate.rate_hz(now_s),
            accuracy=None if self._fix is None else Accuracy(*self._fix, *self._uncertainty_m),
            home_ned_m=None if home is None else (float(home[0]), float(home[1]), float(home[2])),
            transmitter_seen=self._transmitter_seen,
        )

    async def set_heights(self, takeoff_m: float, return_m: float) -> None:
        await self._command("set the take-off height", lambda done: self._action.set_takeoff_altitude_async(takeoff_m, done))
        await self._command(
            "set the return height", lambda done: self._action.set_return_to_launch_altitude_async(return_m, done)
        )

        await self.set_parameter("RTL_CONE_ANG", 0, is_integer=True)

    async def parameter(self, name: str, *, is_integer: bool) -> float | None:
        get = self._param.get_param_int if is_integer else self._param.get_param_float
        try:
            return float(await asyncio.to_thread(get, name))
        except mavsdk.MavsdkError as error:
            result = getattr(getattr(error, "result", None), "name", str(error))
            if result in UNKNOWN_PARAMETER:
                return None
            raise FlightError(f"parameter {name}: {result}") from None

    async def set_parameter(self, name: str, value: float, *, is_integer: bool) -> None:
        if is_integer:
            await self._parameter(name, lambda: self._param.set_param_int(name, int(value)))
        else:
            await self._parameter(name, lambda: self._param.set_param_float(name, value))

    async def arm(self) -> None:
        await self._command("arm", self._action.arm_async)

    async def disarm(self) -> None:
        await self._command("disarm", self._action.disarm_async)

    async def takeoff(self) -> None:
        await self._command("take off", self._action.takeoff_async)

    async def start_offboard(self) -> None:
        await self._command("OFFBOARD", self._offboard.start_async)

    def send(self, setpoint: Setpoint) -> None:
        north, east, down = (float(value) for value in setpoint.velocity_ned_m_s)
        if not math.isfinite(north + east + down + setpoint.yaw_rad):
            raise ValueError(f"setpoint is not finite: velocity {(north, east, down)} m/s, yaw {setpoint.yaw_rad} rad")
        self._offboard.set_velocity_ned(VelocityNedYaw(north, east, down, math.degrees(setpoint.yaw_rad)))

    async def return_to_launch(self) -> None:
        await self._command("return", self._action.return_to_launch_async)

    async def land(self) -> None:
        await self._command("land", self._action.land_async)

    async def terminate(self) -> None:
        await self._command("terminate", self._action.terminate_async)

    def take_status_texts(self) -> list[tuple[float, str, str]]:
        texts = []
        while self._texts:
            texts.append(self._texts.popleft())
        return texts

    def close(self) -> None:
        if self._mavsdk is not None:
            self._mavsdk.destroy()
            self._mavsdk = None

    async def _find_system(self) -> Any:
        """The autopilot with the mission's system id; other vehicles on the same link are not touched."""
        deadline = self._clock.now_s() + self._config.connect_timeout_s
        seen: set[int] = set()
        while self._clock.now_s() < deadline:
            for system in self._mavsdk.get_systems():
                seen.add(system.get_system_id())
                if system.has_autopilot() and system.get_system_id() == self._system_id:
                    return system
            await asyncio.sleep(0.05)
        others = f"; heard system ids {sorted(seen)}" if seen else "; heard nothing at all"
        raise FlightError(
            f"no autopilot with system id {self._system_id} on '{self._config.connection_url}' within "
            f"{self._config.connect_timeout_s:g} s{others}; check cable, MAV_SYS_ID and the mission's system_id"
        )

    def _subscribe(self) -> None:
        telemetry = self._telemetry
        telemetry.subscribe_attitude_euler(self._on_attitude)
        self._direct.subscribe_message("LOCAL_POSITION_NED", self._on_local_position)
        self._direct.subscribe_message("GPS_GLOBAL_ORIGIN", self._on_origin)
        self._direct.subscribe_message("HEARTBEAT", self._on_heartbeat)
        telemetry.subscribe_flight_mode(self._on_flight_mode)
        telemetry.subscribe_armed(self._on_armed)
        telemetry.subscribe_landed_state(self._on_landed)
        telemetry.subscribe_battery(self._on_battery)
        telemetry.subscribe_health(self._on_health)
        telemetry.subscribe_status_text(self._on_status_text)
        telemetry.subscribe_gps_info(self._on_gps_info)
        telemetry.subscribe_raw_gps(self._on_raw_gps)
        telemetry.subscribe_home(self._on_home)
        telemetry.subscribe_rc_status(self._on_rc_status)

    async def _set_rates(self) -> None:
        rate = self._config.telemetry_rate_hz
        await self._command(
            "set the position rate", lambda done: self._telemetry.set_rate_position_velocity_ned_async(rate, done)
        )
        await self._command("set the attitude rate", lambda done: self._telemetry.set_rate_attitude_euler_async(rate, done))
        await self._command("set the landed-state rate", lambda done: self._telemetry.set_rate_landed_state_async(5.0, done))

    def _request_origin(self) -> None:
        now_s = self._clock.now_s()
        if now_s - self._origin_asked_s < ORIGIN_PERIOD_S:
            return
        self._origin_asked_s = now_s

        def take(result: Any, origin: Any, _user: Any) -> None:
            if result.name == "SUCCESS":
                self._origin = GeodeticPoint(origin.latitude_deg, origin.longitude_deg, origin.altitude_m)

        self._telemetry.get_gps_global_origin_async(take)

    async def _describe(self, system: Any) -> str:
        """What the autopilot says of itself; MAVSDK asks for it by itself and has it a moment after discovery."""
        info = Info(system)
        deadline = self._clock.now_s() + VERSION_TIMEOUT_S
        while True:
            try:
                version = info.get_version()
            except mavsdk.MavsdkError as error:
                if self._clock.now_s() > deadline:
                    return f"system {self._system_id}, version unknown ({error})"
                await asyncio.sleep(0.1)
                continue
            self._version = (version.flight_sw_major, version.flight_sw_minor, version.flight_sw_patch)
            with contextlib.suppress(mavsdk.MavsdkError):
                self._hardware_uid = str(info.get_identification().hardware_uid)
            number = f"{version.flight_sw_major}.{version.flight_sw_minor}.{version.flight_sw_patch}"
            return f"system {self._system_id}, autopilot {number}"

    async def _command(self, what: str, start: Callable[[Callable[..., object]], None]) -> None:
        """Start one MAVSDK command and wait for its acknowledgement without blocking the loop."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Any] = loop.create_future()

        def resolve(result: Any) -> None:
            if not answer.done():
                answer.set_result(result)

        start(lambda result, *_: loop.call_soon_threadsafe(resolve, result))
        try:
            result = await asyncio.wait_for(answer, COMMAND_TIMEOUT_S)
        except TimeoutError:
            raise FlightError(f"autopilot gave no answer to '{what}' within {COMMAND_TIMEOUT_S:g} s") from None
        if result.name != "SUCCESS":
            await asyncio.sleep(COMPLAINT_DELAY_S)
            lately_s = self._clock.now_s() - COMPLAINT_AGE_MAX_S
            reasons = "; ".join(text for arrived_s, text in tuple(self._complaints) if arrived_s > lately_s)
            raise FlightError(f"autopilot refused '{what}': {result.name}{f' ({reasons})' if reasons else ''}")

    async def _parameter(self, name: str, call: Callable[[], Any]) -> Any:
        """One parameter call, on the ground only: it blocks a thread of the default pool until the autopilot answers."""
        try:
            return await asyncio.to_thread(call)
        except mavsdk.MavsdkError as error:
            result = getattr(error, "result", None)
            raise FlightError(f"parameter {name}: {getattr(result, 'name', error)}") from None

    def _on_attitude(self, attitude: Any, _user: Any) -> None:
        arrived_s = self._clock.now_s()
        self._attitude_rate.note(arrived_s)
        self._twin.note(attitude.timestamp_us * 1e-6, arrived_s)
        t_s = self._boot_clock.to_fleet_s(attitude.timestamp_us * 1e-6, arrived_s)
        roll, pitch, yaw = (math.radians(angle) for angle in (attitude.roll_deg, attitude.pitch_deg, attitude.yaw_deg))
        if math.isfinite(roll + pitch + yaw):
            self._attitude = (roll, pitch, yaw)
            self._history.append_attitude(t_s, roll, pitch, wrap_pi(yaw))

    def _on_local_position(self, message: Any, _user: Any) -> None:
        if message.system_id != self._system_id or self._origin is None or self._attitude is None:
            return
        arrived_s = self._clock.now_s()
        self._state_rate.note(arrived_s)
        fields = json.loads(message.fields_json)
        local = np.array([fields["x"], fields["y"], fields["z"]], dtype=np.float64)
        velocity = np.array([fields["vx"], fields["vy"], fields["vz"]], dtype=np.float64)
        if not (np.isfinite(local).all() and np.isfinite(velocity).all()):
            return
        t_s = self._boot_clock.to_fleet_s(fields["time_boot_ms"] * 1e-3, arrived_s)
        position = geodetic_to_mission(self._datum, px4_local_to_geodetic(self._origin, local))
        roll, pitch, yaw = self._attitude
        state = VehicleState(t_s, position, velocity, wrap_pi(yaw))
        self._history.append_state(state)
        self._motion = Motion(state, roll, pitch, arrived_s)

    def _on_origin(self, message: Any, _user: Any) -> None:
        if message.system_id == self._system_id:
            fields = json.loads(message.fields_json)
            self._origin = GeodeticPoint(fields["latitude"] * 1e-7, fields["longitude"] * 1e-7, fields["altitude"] * 1e-3)

    def _on_heartbeat(self, message: Any, _user: Any) -> None:
        if message.system_id == self._system_id and message.component_id == AUTOPILOT_COMPONENT_ID:
            number = int(json.loads(message.fields_json)["autopilot"])
            self._autopilot = AUTOPILOTS.get(number, f"MAV_AUTOPILOT {number}")

    def _on_flight_mode(self, mode: Any, _user: Any) -> None:
        self._mode = FlightMode(mode).name
        self._heartbeat_s = self._clock.now_s()

    def _on_armed(self, armed: Any, _user: Any) -> None:
        self._armed = bool(armed)

    def _on_landed(self, state: Any, _user: Any) -> None:
        self._landed = LandedState(state).name

    def _on_battery(self, battery: Any, _user: Any) -> None:
        voltage = battery.voltage_v if math.isfinite(battery.voltage_v) else None
        percent = battery.remaining_percent
        self._battery = BatteryState(voltage, percent / 100.0 if math.isfinite(percent) else None)

    def _on_health(self, health: Any, _user: Any) -> None:
        self._health = (health.is_global_position_ok, health.is_home_position_ok, health.is_armable)

    def _on_status_text(self, text: Any, _user: Any) -> None:
        now_s = self._clock.now_s()
        self._texts.append((now_s, text.type.name, text.text))
        if text.type.name in COMPLAINTS:
            self._complaints.append((now_s, text.text))

    def _on_gps_info(self, gps: Any, _user: Any) -> None:
        self._fix = (int(gps.num_satellites), FixType(gps.fix_type).value)

    def _on_raw_gps(self, gps: Any, _user: Any) -> None:
        self._uncertainty_m = (_told_m(gps.horizontal_uncertainty_m), _told_m(gps.vertical_uncertainty_m))

    def _on_home(self, home: Any, _user: Any) -> None:
        point = GeodeticPoint(home.latitude_deg, home.longitude_deg, home.absolute_altitude_m)
        if math.isfinite(point.latitude_deg + point.longitude_deg + point.altitude_m):
            self._home = point

    def _on_rc_status(self, transmitter: Any, _user: Any) -> None:
        self._transmitter_seen = bool(transmitter.is_available)


def _told_m(uncertainty_m: float) -> float:
    """MAVLink 1 has no field for it and MAVLink 2 sends 0 where the receiver does not tell."""
    return uncertainty_m if math.isfinite(uncertainty_m) and uncertainty_m > 0.0 else math.nan
