"""The mock's telemetry: one builder a message, a schedule with PX4's kinds of rates, and the faults on telemetry."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from flightapp.core.geodesy import GeodeticPoint
from flightapp.sim.autopilot_core import AutopilotCore
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_script import ActiveFault
from flightapp.sim.mavlink_dialect import Message, mavlink
from flightapp.sim.multirotor import Vector

RATE_MAX_HZ = 125.0
DEFAULT_RATES_HZ: dict[int, float] = {
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 50.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 50.0,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 10.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 5.0,
    mavlink.MAVLINK_MSG_ID_ODOMETRY: 5.0,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 5.0,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: 2.0,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 2.0,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1.0,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 1.0,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
    mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: 0.2,
}
_HEARTBEAT_S = 1.0
_GRID_S = 0.02
_EARLY_S = 1e-4
"""Much less than a step: rounding must not make a message late by one."""
_SENSORS = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
    | mavlink.MAV_SYS_STATUS_SENSOR_YAW_POSITION
    | mavlink.MAV_SYS_STATUS_SENSOR_Z_ALTITUDE_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
    | mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
    | mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER
    | mavlink.MAV_SYS_STATUS_AHRS
    | mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    | mavlink.MAV_SYS_STATUS_PREARM_CHECK
)
_POSITION_SENSORS = mavlink.MAV_SYS_STATUS_SENSOR_GPS | mavlink.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
_INTEGER_RANGES = {
    "int8_t": (-128, 127),
    "uint8_t": (0, 255),
    "int16_t": (-32768, 32767),
    "uint16_t": (0, 65535),
    "int32_t": (-(2**31), 2**31 - 1),
    "uint32_t": (0, 2**32 - 1),
    "int64_t": (-(2**63), 2**63 - 1),
    "uint64_t": (0, 2**64 - 1),
}


@dataclass(frozen=True, slots=True)
class Outgoing:
    """A message on its way out; `broken`: flip bits after packing, so that its checksum is wrong."""

    message: Message
    delay_s: float = 0.0
    broken: bool = False


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The values that telemetry reports, at one moment."""

    position_ned_m: Vector
    """Estimated, mission frame."""
    point: GeodeticPoint
    local_ned_m: Vector
    velocity_ned_m_s: Vector
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    rates_rad_s: Vector
    valid: bool


class Telemetry:
    """Streams of one vehicle. `poll` after each step of the core gives what is due."""

    def __init__(self, core: AutopilotCore) -> None:
        self._core = core
        self._builders: dict[int, Callable[[], Message | None]] = {
            mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: self._local_position,
            mavlink.MAVLINK_MSG_ID_ATTITUDE: self._attitude,
            mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: self._global_position,
            mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: self._attitude_quaternion,
            mavlink.MAVLINK_MSG_ID_ODOMETRY: self._odometry,
            mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: self._gps_raw,
            mavlink.MAVLINK_MSG_ID_VFR_HUD: self._vfr_hud,
            mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: self._extended_sys_state,
            mavlink.MAVLINK_MSG_ID_SYS_STATUS: self._sys_status,
            mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: self._battery_status,
            mavlink.MAVLINK_MSG_ID_HOME_POSITION: self._home_position,
            mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: self._origin,
        }
        self._on_request: dict[int, Callable[[], Message | None]] = {
            **self._builders,
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self.heartbeat,
            mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION: self._version,
        }
        self._interval_s: dict[int, float] = {number: 1.0 / rate for number, rate in DEFAULT_RATES_HZ.items()}
        # On one grid, so that messages share datagrams, but the slow streams on different points of it.
        self._due_s: dict[int, float] = {number: _GRID_S * index for index, number in enumerate(self._interval_s)}
        self._next_s = 0.0
        self._next_heartbeat_s = 0.0
        self._snapshot: Snapshot | None = None
        self._snapshot_s = -1.0
        self._stuck: Snapshot | None = None

    def set_interval(self, number: int, interval_us: float) -> bool:
        """SET_MESSAGE_INTERVAL: -1 off, 0 default. False for a message that the mock does not stream."""
        if number not in self._builders:
            return False
        if interval_us < 0:
            interval_s = math.inf
        elif interval_us == 0:
            interval_s = 1.0 / DEFAULT_RATES_HZ[number]
        else:
            interval_s = max(interval_us * 1e-6, 1.0 / RATE_MAX_HZ)
        self._interval_s[number] = interval_s
        self._due_s[number] = _on_grid(self._core.t_s) if math.isfinite(interval_s) else math.inf
        self._next_s = min(self._due_s.values())
        return True

    def interval_us(self, number: int) -> int | None:
        """The present interval; -1 off, None unknown."""
        interval_s = self._interval_s.get(number)
        if interval_s is None:
            return None
        return round(interval_s * 1e6) if math.isfinite(interval_s) else -1

    def requested(self, number: int) -> Message | None:
        """A message asked for once; None where it is unknown or has no valid content now."""
        builder = self._on_request.get(number)
        return None if builder is None else builder()

    def knows(self, number: int) -> bool:
        return number in self._on_request

    def poll(self) -> list[Outgoing]:
        """Everything that is due now."""
        core, out = self._core, []
        t_s = core.t_s
        if (core.heartbeat_due and core.heartbeat_on_change) or t_s >= self._next_heartbeat_s:
            core.heartbeat_due = False
            self._next_heartbeat_s = t_s + _HEARTBEAT_S
            out.append(Outgoing(self.heartbeat()))
        while core.status_texts:
            severity, text = core.status_texts.popleft()
            out.append(Outgoing(mavlink.MAVLink_statustext_message(severity, text.encode())))
        if t_s >= self._next_s - _EARLY_S:
            fault = core.faults.on("telemetry")
            slow = fault.get("factor") if fault is not None and fault.verb == "slow" else 1.0
            for number, due_s in self._due_s.items():
                if t_s < due_s - _EARLY_S:
                    continue
                interval_s = self._interval_s[number] * slow * self._battery_slowness(number)
                self._due_s[number] = due_s + interval_s if t_s < due_s + interval_s else t_s + interval_s
                self._stream(number, fault, out)
            self._next_s = min(self._due_s.values())
            if fault is None:
                self._stuck = None
        return out

    def heartbeat(self) -> Message:
        core = self._core
        custom_mode = core.mode.custom_mode
        fault = core.faults.on("mode")
        if fault is not None and fault.verb == "garbage":
            fault.felt("nonsense mode in the heartbeat")
            custom_mode = fault.random.randrange(2**32)
        base_mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
        if core.mode.is_auto or core.mode is Mode.OFFBOARD:
            base_mode |= mavlink.MAV_MODE_FLAG_AUTO_ENABLED | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
        else:
            base_mode |= mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        state = mavlink.MAV_STATE_STANDBY
        if core.armed:
            base_mode |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED
            state = mavlink.MAV_STATE_CRITICAL if core.failsafe else mavlink.MAV_STATE_ACTIVE
        return mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4, base_mode, custom_mode, state, 3
        )

    # -- faults on telemetry --------------------------------------------------------------------------------------

    def _stream(self, number: int, fault: ActiveFault | None, out: list[Outgoing]) -> None:
        if fault is not None and (fault.verb == "off" or (fault.verb == "intermittent" and fault.bites())):
            fault.felt("stream suppressed")
            return
        if number == mavlink.MAVLINK_MSG_ID_BATTERY_STATUS and self._battery_is_silent():
            return
        message = self._builders[number]()
        if message is None:
            return
        if fault is None:
            out.append(Outgoing(message))
        elif fault.verb == "delayed":
            fault.felt("stream delayed")
            out.append(Outgoing(message, delay_s=fault.get("delay_s")))
        elif fault.verb == "garbage" and fault.random.random() < fault.get("fraction"):
            fault.felt("nonsense sent")
            broken = fault.random.random() < 0.5
            if not broken:
                _scramble(message, fault)
            out.append(Outgoing(message, broken=broken))
        else:
            if fault.verb == "slow":
                fault.felt("rate divided")
            out.append(Outgoing(message))

    def _battery_is_silent(self) -> bool:
        fault = self._core.faults.on("battery")
        if fault is None or fault.verb != "intermittent" or not fault.bites():
            return False
        fault.felt("BATTERY_STATUS suppressed")
        return True

    def _battery_slowness(self, number: int) -> float:
        if number != mavlink.MAVLINK_MSG_ID_BATTERY_STATUS:
            return 1.0
        fault = self._core.faults.on("battery")
        if fault is None or fault.verb != "slow":
            return 1.0
        fault.felt("BATTERY_STATUS rate divided")
        return float(fault.get("factor"))

    def _now(self) -> Snapshot:
        """The reported values, computed once a step."""
        core = self._core
        if self._snapshot is None or self._snapshot_s != core.t_s:
            self._snapshot = self._take()
            self._snapshot_s = core.t_s
        fault = core.faults.on("telemetry")
        if fault is None or fault.verb not in ("stuck", "wrong"):
            return self._snapshot
        if fault.verb == "stuck":
            if self._stuck is None:
                self._stuck = self._snapshot
            elif self._stuck != self._snapshot:
                fault.felt("values repeated")
            return self._stuck
        fault.felt("position offset")
        offset_m = fault.get("offset_m")
        north, east, down = self._snapshot.position_ned_m
        shifted = (north + offset_m, east, down)
        point = core.frames.to_geodetic(shifted)
        return replace(self._snapshot, position_ned_m=shifted, point=point, local_ned_m=core.frames.geodetic_to_local(point))

    def _take(self) -> Snapshot:
        core = self._core
        estimate, vehicle = core.estimate(), core.vehicle
        point = core.frames.to_geodetic(estimate.position_ned_m)
        return Snapshot(
            estimate.position_ned_m,
            point,
            core.frames.geodetic_to_local(point),
            estimate.velocity_ned_m_s,
            vehicle.roll_rad,
            vehicle.pitch_rad,
            vehicle.yaw_rad,
            (vehicle.roll_rate_rad_s, vehicle.pitch_rate_rad_s, vehicle.yaw_rate_rad_s),
            core.position_valid,
        )

    # -- messages -------------------------------------------------------------------------------------------------

    def _boot_ms(self) -> int:
        return int(self._core.t_s * 1e3)

    def _boot_us(self) -> int:
        return int(self._core.t_s * 1e6)

    def _local_position(self) -> Message | None:
        now = self._now()
        if not now.valid:
            return None
        return mavlink.MAVLink_local_position_ned_message(self._boot_ms(), *now.local_ned_m, *now.velocity_ned_m_s)

    def _global_position(self) -> Message | None:
        now = self._now()
        if not now.valid:
            return None
        v = now.velocity_ned_m_s
        relative_m = self._core.navigator.home_ned_m[2] - now.position_ned_m[2] if self._core.home_set else 0.0
        return mavlink.MAVLink_global_position_int_message(
            self._boot_ms(),
            round(now.point.latitude_deg * 1e7),
            round(now.point.longitude_deg * 1e7),
            round(now.point.altitude_m * 1e3),
            round(relative_m * 1e3),
            *(_within(c * 100.0, 32767) for c in v),
            round(math.degrees(now.yaw_rad) % 360.0 * 100.0) % 36000,
        )

    def _attitude(self) -> Message:
        now = self._now()
        return mavlink.MAVLink_attitude_message(self._boot_ms(), now.roll_rad, now.pitch_rad, now.yaw_rad, *now.rates_rad_s)

    def _attitude_quaternion(self) -> Message:
        now = self._now()
        return mavlink.MAVLink_attitude_quaternion_message(self._boot_ms(), *_quaternion(now), *now.rates_rad_s)

    def _odometry(self) -> Message | None:
        now = self._now()
        if not now.valid:
            return None
        return mavlink.MAVLink_odometry_message(
            self._boot_us(),
            mavlink.MAV_FRAME_LOCAL_NED,
            mavlink.MAV_FRAME_BODY_FRD,
            *now.local_ned_m,
            _quaternion(now),
            *_to_body(now),
            *now.rates_rad_s,
            _POSITION_COVARIANCE,
            _VELOCITY_COVARIANCE,
            0,
            mavlink.MAV_ESTIMATOR_TYPE_AUTOPILOT,
            100,
        )

    def _gps_raw(self) -> Message:
        core = self._core
        fix = core.estimator.gps.fix
        point = core.frames.to_geodetic(core.estimator.gps_position_ned_m)
        north, east, _ = core.vehicle.velocity_ned_m_s
        return mavlink.MAVLink_gps_raw_int_message(
            self._boot_us(),
            mavlink.GPS_FIX_TYPE_3D_FIX if fix else mavlink.GPS_FIX_TYPE_NO_FIX,
            round(point.latitude_deg * 1e7) if fix else 0,
            round(point.longitude_deg * 1e7) if fix else 0,
            round(point.altitude_m * 1e3) if fix else 0,
            70 if fix else 65535,
            100 if fix else 65535,
            _within(math.hypot(north, east) * 100.0, 65534) if fix else 65535,
            round(math.degrees(math.atan2(east, north)) % 360.0 * 100.0) % 36000 if fix else 65535,
            14 if fix else 0,
        )

    def _vfr_hud(self) -> Message | None:
        now = self._now()
        if not now.valid:
            return None
        north, east, down = now.velocity_ned_m_s
        speed = math.hypot(north, east)
        heading = round(math.degrees(now.yaw_rad) % 360.0) % 360
        throttle = 50 if self._core.armed else 0
        return mavlink.MAVLink_vfr_hud_message(speed, speed, heading, throttle, now.point.altitude_m, -down)

    def _extended_sys_state(self) -> Message:
        return mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, self._core.landed_state)

    def _sys_status(self) -> Message:
        core = self._core
        healthy = _SENSORS
        if not core.position_valid:
            healthy &= ~_POSITION_SENSORS
        if core.preflight_fault() is not None and not core.armed:
            healthy &= ~mavlink.MAV_SYS_STATUS_PREARM_CHECK
        battery = core.battery
        millivolts = round(battery.voltage_v(int(core.parameters["BAT1_N_CELLS"])) * 1e3)
        return mavlink.MAVLink_sys_status_message(
            _SENSORS,
            _SENSORS,
            healthy,
            300,
            millivolts,
            round(battery.current_a * 100.0),
            math.ceil(battery.remaining * 100.0),
            *(0,) * 6,
        )

    def _battery_status(self) -> Message:
        core = self._core
        battery, cells = core.battery, int(core.parameters["BAT1_N_CELLS"])
        cell_mv = round(battery.voltage_v(cells) / cells * 1e3)
        level = mavlink.MAV_BATTERY_CHARGE_STATE_OK
        if battery.remaining < float(core.parameters["BAT_EMERGEN_THR"]):
            level = mavlink.MAV_BATTERY_CHARGE_STATE_EMERGENCY
        elif battery.remaining < float(core.parameters["BAT_CRIT_THR"]):
            level = mavlink.MAV_BATTERY_CHARGE_STATE_CRITICAL
        elif battery.remaining < float(core.parameters["BAT_LOW_THR"]):
            level = mavlink.MAV_BATTERY_CHARGE_STATE_LOW
        return mavlink.MAVLink_battery_status_message(
            0,
            mavlink.MAV_BATTERY_FUNCTION_ALL,
            mavlink.MAV_BATTERY_TYPE_LIPO,
            2500,
            [cell_mv] * cells + [65535] * (10 - cells),
            round(battery.current_a * 100.0),
            round(battery.consumed_mah),
            -1,
            math.ceil(battery.remaining * 100.0),
            0,
            level,
        )

    def _home_position(self) -> Message | None:
        core = self._core
        if not core.home_set:
            return None
        home = core.navigator.home_ned_m
        point = core.frames.to_geodetic(home)
        return mavlink.MAVLink_home_position_message(
            round(point.latitude_deg * 1e7),
            round(point.longitude_deg * 1e7),
            round(point.altitude_m * 1e3),
            *core.frames.geodetic_to_local(point),
            [1.0, 0.0, 0.0, 0.0],
            0.0,
            0.0,
            0.0,
            self._boot_us(),
        )

    def _origin(self) -> Message:
        origin = self._core.frames.origin
        return mavlink.MAVLink_gps_global_origin_message(
            round(origin.latitude_deg * 1e7), round(origin.longitude_deg * 1e7), round(origin.altitude_m * 1e3), self._boot_us()
        )

    def _version(self) -> Message:
        capabilities = (
            mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
            | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
            | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
            | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
            | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
            | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        )
        version = 1 << 24 | 16 << 16 | 1 << 8 | 255
        uid = 0x4D4F434B0000 + int(self._core.parameters["MAV_SYS_ID"])
        return mavlink.MAVLink_autopilot_version_message(
            capabilities, version, version, version, 0, [0] * 8, [0] * 8, [0] * 8, 0x26AC, 0x0010, uid
        )


def _diagonal(first: float, second: float) -> list[float]:
    """Upper triangle (21) of a 6x6 covariance with three variances of each kind."""
    values = [0.0] * 21
    for place, value in zip((0, 6, 11, 15, 18, 20), (first,) * 3 + (second,) * 3, strict=True):
        values[place] = value
    return values


_POSITION_COVARIANCE = _diagonal(0.01, 0.0004)
_VELOCITY_COVARIANCE = _diagonal(0.004, 0.0004)


def _on_grid(t_s: float) -> float:
    return math.ceil(t_s / _GRID_S) * _GRID_S


def _within(value: float, limit: int) -> int:
    return round(min(max(value, -limit), limit))


def _quaternion(now: Snapshot) -> list[float]:
    """Rotation from body FRD to NED, w first."""
    cr, sr = math.cos(now.roll_rad / 2), math.sin(now.roll_rad / 2)
    cp, sp = math.cos(now.pitch_rad / 2), math.sin(now.pitch_rad / 2)
    cy, sy = math.cos(now.yaw_rad / 2), math.sin(now.yaw_rad / 2)
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]


def _to_body(now: Snapshot) -> Vector:
    """Velocity in body FRD."""
    w, x, y, z = _quaternion(now)
    n, e, d = now.velocity_ned_m_s
    return (
        (1 - 2 * (y * y + z * z)) * n + 2 * (x * y + w * z) * e + 2 * (x * z - w * y) * d,
        2 * (x * y - w * z) * n + (1 - 2 * (x * x + z * z)) * e + 2 * (y * z + w * x) * d,
        2 * (x * z + w * y) * n + 2 * (y * z - w * x) * e + (1 - 2 * (x * x + y * y)) * d,
    )


def _scramble(message: Message, fault: ActiveFault) -> None:
    """Replace every scalar value but the time by finite nonsense of its type."""
    for name, kind in zip(message.fieldnames, message.fieldtypes, strict=True):
        value = getattr(message, name)
        if name.startswith("time_") or isinstance(value, (list, tuple, str, bytes)):
            continue
        if kind in _INTEGER_RANGES:
            setattr(message, name, fault.random.randint(*_INTEGER_RANGES[kind]))
        else:
            setattr(message, name, fault.random.uniform(-1000.0, 1000.0))
