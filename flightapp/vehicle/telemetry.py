"""The newest of everything that the autopilot tells, in slots that MAVSDK's one thread fills and the control loop reads.

Polled values of MAVSDK never expire, so what matters has its own arrival time here. Positions leave this file in the mission
frame: each autopilot has its own local origin, and the way from one to the other leads through geodetic coordinates.
"""

from __future__ import annotations

import json
import math
from collections import deque
from typing import Any

import numpy as np
from mavsdk.plugins.mavlink_direct import MavlinkDirect
from mavsdk.plugins.telemetry import FixType, FlightMode, LandedState, Telemetry

from flightapp.core.angles import wrap_pi
from flightapp.core.clock import Clock
from flightapp.core.geodesy import GeodeticPoint, geodetic_to_mission, px4_local_to_geodetic
from flightapp.core.types import VehicleState
from flightapp.vehicle.autopilot import Accuracy, BatteryState, Motion, Status
from flightapp.vehicle.boot_clock import BootClock
from flightapp.vehicle.commands import Commands
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.rate_meter import RateMeter
from flightapp.vehicle.twin_watch import TwinWatch

AUTOPILOT_COMPONENT_ID = 1
AUTOPILOTS = {0: "generic", 3: "ArduPilot", 12: "PX4"}
"""MAVLink MAV_AUTOPILOT."""
CONNECTION_LOST_S = 3.0
ORIGIN_PERIOD_S = 1.0
LANDED_STATE_RATE_HZ = 5.0
RESTARTED_S = 1.0
"""Time since boot that runs back by more than this was not only reordered on the way."""
COMPLAINTS = ("WARNING", "ERROR", "CRITICAL", "ALERT", "EMERGENCY")


class TelemetrySlots:
    """`subscribe` once; from then on every attribute is the newest word of the autopilot."""

    def __init__(self, system_id: int, datum: GeodeticPoint, clock: Clock, history: PoseHistory) -> None:
        self._system_id = system_id
        self._datum = datum
        self._clock = clock
        self._history = history
        self.autopilot = ""
        """PX4, or what it is instead; empty while unknown."""
        self.motion: Motion | None = None
        self.battery: BatteryState | None = None
        self.healthy = (False, False, False)
        """Global position, home position, ready to arm."""
        self.transmitter_seen: bool | None = None
        self.state_rate, self.attitude_rate = RateMeter(), RateMeter()
        self._boot_clock, self._twin = BootClock(), TwinWatch()
        self._twin_told = False
        self._boot_s = 0.0
        self._attitude: tuple[float, float, float] | None = None
        self._origin: GeodeticPoint | None = None
        self._origin_asked_s = -math.inf
        self._mode, self._armed, self._landed = "UNKNOWN", False, "UNKNOWN"
        self._heartbeat_s = -math.inf
        self._fix: tuple[int, int] | None = None
        self._uncertainty_m = (math.nan, math.nan)
        self._home: GeodeticPoint | None = None
        self._texts: deque[tuple[float, str, str]] = deque(maxlen=200)
        self._complaints: deque[tuple[float, str]] = deque(maxlen=10)

    def subscribe(self, system: Any) -> None:
        self._telemetry = telemetry = Telemetry(system)
        self._direct = direct = MavlinkDirect(system)
        telemetry.subscribe_attitude_euler(self._on_attitude)
        direct.subscribe_message("LOCAL_POSITION_NED", self._on_local_position)
        direct.subscribe_message("GPS_GLOBAL_ORIGIN", self._on_origin)
        direct.subscribe_message("HEARTBEAT", self._on_heartbeat)
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

    async def set_rates(self, commands: Commands, rate_hz: float) -> None:
        """Ask for position and attitude at `rate_hz`; FlightError when that is refused."""
        telemetry = self._telemetry
        await commands.run("set the position rate", lambda done: telemetry.set_rate_position_velocity_ned_async(rate_hz, done))
        await commands.run("set the attitude rate", lambda done: telemetry.set_rate_attitude_euler_async(rate_hz, done))
        await commands.run(
            "set the landed-state rate", lambda done: telemetry.set_rate_landed_state_async(LANDED_STATE_RATE_HZ, done)
        )

    def request_origin(self) -> None:
        """Ask for the local origin where it is not known, once a second at most."""
        now_s = self._clock.now_s()
        if self._origin is not None or now_s - self._origin_asked_s < ORIGIN_PERIOD_S:
            return
        self._origin_asked_s = now_s

        def take(result: Any, origin: Any, _user: Any) -> None:
            if result.name == "SUCCESS":
                self._origin = GeodeticPoint(origin.latitude_deg, origin.longitude_deg, origin.altitude_m)

        self._telemetry.get_gps_global_origin_async(take)

    @property
    def origin_known(self) -> bool:
        return self._origin is not None

    def status(self) -> Status:
        connected = self._clock.now_s() - self._heartbeat_s < CONNECTION_LOST_S
        return Status(connected, self._mode, self._armed, self._landed, self._heartbeat_s)

    def twin(self, now_s: float) -> str:
        """How a second autopilot with the same system id shows now; empty while there is no sign of one."""
        return self._twin.sign(now_s)

    def accuracy(self) -> Accuracy | None:
        return None if self._fix is None else Accuracy(*self._fix, *self._uncertainty_m)

    def home_ned_m(self) -> tuple[float, float, float] | None:
        if self._home is None:
            return None
        north, east, down = geodetic_to_mission(self._datum, self._home)
        return float(north), float(east), float(down)

    def complaints(self, since_s: float) -> list[str]:
        """Warnings and errors of the autopilot since `since_s`."""
        return [text for arrived_s, text in tuple(self._complaints) if arrived_s > since_s]

    def take_texts(self) -> list[tuple[float, str, str]]:
        """(arrival, severity, text) since the last call."""
        texts = []
        while self._texts:
            texts.append(self._texts.popleft())
        return texts

    def _on_attitude(self, attitude: Any, _user: Any) -> None:
        arrived_s = self._clock.now_s()
        self.attitude_rate.note(arrived_s)
        self._twin.note(attitude.timestamp_us * 1e-6, arrived_s)
        self._tell_twin(arrived_s)
        self._note_restart(attitude.timestamp_us * 1e-6)
        t_s = self._boot_clock.to_fleet_s(attitude.timestamp_us * 1e-6, arrived_s)
        roll, pitch, yaw = (math.radians(angle) for angle in (attitude.roll_deg, attitude.pitch_deg, attitude.yaw_deg))
        if math.isfinite(roll + pitch + yaw):
            self._attitude = (roll, pitch, yaw)
            self._history.append_attitude(t_s, roll, pitch, wrap_pi(yaw))

    def _note_restart(self, boot_s: float) -> None:
        """An autopilot that started anew has another local origin: no position until that is known."""
        if boot_s < self._boot_s - RESTARTED_S:
            self.motion, self._origin, self._origin_asked_s = None, None, -math.inf
        self._boot_s = boot_s

    def _tell_twin(self, now_s: float) -> None:
        """On the ground preflight refuses a twin; one that is switched on during the flight becomes an event."""
        sign = self._twin.sign(now_s)
        if sign and not self._twin_told:
            self._texts.append((now_s, "CRITICAL", sign))
        self._twin_told = bool(sign)

    def _on_local_position(self, message: Any, _user: Any) -> None:
        if message.system_id != self._system_id or self._origin is None or self._attitude is None:
            return
        arrived_s = self._clock.now_s()
        self.state_rate.note(arrived_s)
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
        self.motion = Motion(state, roll, pitch, arrived_s)

    def _on_origin(self, message: Any, _user: Any) -> None:
        if message.system_id == self._system_id:
            fields = json.loads(message.fields_json)
            self._origin = GeodeticPoint(fields["latitude"] * 1e-7, fields["longitude"] * 1e-7, fields["altitude"] * 1e-3)

    def _on_heartbeat(self, message: Any, _user: Any) -> None:
        if message.system_id == self._system_id and message.component_id == AUTOPILOT_COMPONENT_ID:
            number = int(json.loads(message.fields_json)["autopilot"])
            self.autopilot = AUTOPILOTS.get(number, f"MAV_AUTOPILOT {number}")

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
        self.battery = BatteryState(voltage, percent / 100.0 if math.isfinite(percent) else None)

    def _on_health(self, health: Any, _user: Any) -> None:
        self.healthy = (health.is_global_position_ok, health.is_home_position_ok, health.is_armable)

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
        self.transmitter_seen = bool(transmitter.is_available)


def _told_m(uncertainty_m: float) -> float:
    """MAVLink 1 has no field for it and MAVLink 2 sends 0 where the receiver does not tell."""
    return uncertainty_m if math.isfinite(uncertainty_m) and uncertainty_m > 0.0 else math.nan
