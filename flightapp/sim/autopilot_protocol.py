"""What the mock answers: commands, parameters, setpoints, fence upload, time. Pure: a message in, messages out."""

from __future__ import annotations

import math
from collections.abc import Callable

from flightapp.core.geodesy import GeodeticPoint
from flightapp.sim.autopilot_core import ACCEPTED, DENIED, TEMPORARILY_REJECTED, AutopilotCore, Done
from flightapp.sim.autopilot_modes import Mode, mode_of
from flightapp.sim.autopilot_navigator import OffboardSetpoint
from flightapp.sim.autopilot_telemetry import Outgoing, Telemetry
from flightapp.sim.mavlink_dialect import Message, mavlink
from flightapp.sim.multirotor import Vector

UNSUPPORTED = int(mavlink.MAV_RESULT_UNSUPPORTED)
FAILED = int(mavlink.MAV_RESULT_FAILED)
COMPONENT_ID = int(mavlink.MAV_COMP_ID_AUTOPILOT1)
_FORCE_DISARM = 21196.0
_BODY_FRAMES = (mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED, mavlink.MAV_FRAME_BODY_FRD)
_PARAM_DOES_NOT_EXIST = int(mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST)
_NAN: Vector = (math.nan, math.nan, math.nan)
_PARAMS_PER_POLL = 4

Parameters7 = tuple[float, float, float, float, float, float, float]


class Protocol:
    """Handles the messages addressed to one autopilot; collects the answers."""

    def __init__(self, core: AutopilotCore, telemetry: Telemetry, system_id: int) -> None:
        self._core = core
        self._telemetry = telemetry
        self._system_id = system_id
        self._out: list[Outgoing] = []
        self._to_list: list[str] = []
        self._upload: tuple[int, int, int, int] | None = None
        """Sender, its component, kind and length of the mission that is being uploaded."""
        self._plans: dict[int, list[Message]] = {}
        self._handlers: dict[int, Callable[[Message], None]] = {
            mavlink.MAVLINK_MSG_ID_COMMAND_LONG: self._command_long,
            mavlink.MAVLINK_MSG_ID_COMMAND_INT: self._command_int,
            mavlink.MAVLINK_MSG_ID_SET_MODE: self._set_mode,
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: self._setpoint_local,
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: self._setpoint_global,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: self._param_read,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: self._param_list,
            mavlink.MAVLINK_MSG_ID_PARAM_SET: self._param_set,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._timesync,
            mavlink.MAVLINK_MSG_ID_PING: self._ping,
            mavlink.MAVLINK_MSG_ID_MISSION_COUNT: self._mission_count,
            mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT: self._mission_item,
            mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: self._mission_clear,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: self._mission_list,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT: self._mission_request,
        }

    def handle(self, message: Message) -> None:
        """Act on a message; one for another system or component is ignored without a word."""
        if getattr(message, "target_system", 0) not in (0, self._system_id):
            return
        if getattr(message, "target_component", 0) not in (0, COMPONENT_ID):
            return
        handler = self._handlers.get(message.get_msgId())
        if handler is not None:
            handler(message)

    def poll(self) -> list[Outgoing]:
        """The answers since the last call, and the next few parameters of a list that is being sent."""
        out, self._out = self._out, []
        for name in self._to_list[:_PARAMS_PER_POLL]:
            out.append(Outgoing(self._param_value(name)))
        del self._to_list[:_PARAMS_PER_POLL]
        return out

    def _send(self, message: Message) -> None:
        self._out.append(Outgoing(message))

    # -- commands -------------------------------------------------------------------------------------------------

    def _command_long(self, message: Message) -> None:
        values = tuple(getattr(message, f"param{index}") for index in range(1, 8))
        self._command(message, message.command, values)

    def _command_int(self, message: Message) -> None:
        values = (message.param1, message.param2, message.param3, message.param4, message.x * 1e-7, message.y * 1e-7, message.z)
        self._command(message, message.command, values)

    def _command(self, message: Message, command: int, values: Parameters7) -> None:
        system, component = message.get_srcSystem(), message.get_srcComponent()

        def done(result: int) -> None:
            self._send(mavlink.MAVLink_command_ack_message(command, result, 0, 0, system, component))

        core = self._core
        if command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            core.command_arm(values[0] > 0.5, values[1] == _FORCE_DISARM, done)
        elif command == mavlink.MAV_CMD_DO_SET_MODE:
            self._do_set_mode(int(values[1]), int(values[2]), done)
        elif command == mavlink.MAV_CMD_NAV_TAKEOFF:
            core.command_mode(Mode.TAKEOFF, done, takeoff_height_m=self._takeoff_height_m(values[6]))
        elif command == mavlink.MAV_CMD_NAV_LAND:
            core.command_mode(Mode.LAND, done)
        elif command == mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH:
            core.command_mode(Mode.RTL, done)
        elif command == mavlink.MAV_CMD_DO_FLIGHTTERMINATION:
            if values[0] > 0.5:
                core.terminate("Flight termination by command")
            done(int(ACCEPTED))
        else:
            done(self._immediate(command, values))

    def _immediate(self, command: int, values: Parameters7) -> int:
        """Commands whose result is known at once."""
        if command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            return int(ACCEPTED) if self._telemetry.set_interval(int(values[0]), values[1]) else FAILED
        if command == mavlink.MAV_CMD_GET_MESSAGE_INTERVAL:
            number = int(values[0])
            interval_us = self._telemetry.interval_us(number)
            self._send(mavlink.MAVLink_message_interval_message(number, 0 if interval_us is None else interval_us))
            return int(ACCEPTED)
        if command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            return self._request(int(values[0]))
        if command == mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
            return self._request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
        if command == mavlink.MAV_CMD_DO_CHANGE_SPEED:
            self._core.navigator.cruise_speed_m_s = values[1] if values[1] > 0.0 else None
            return int(ACCEPTED)
        if command == mavlink.MAV_CMD_DO_REPOSITION:
            return self._reposition(values)
        if command == mavlink.MAV_CMD_DO_SET_HOME:
            if values[0] < 0.5:
                return int(DENIED)
            self._core.set_home()
            return int(ACCEPTED)
        return UNSUPPORTED

    def _request(self, number: int) -> int:
        if not self._telemetry.knows(number):
            return UNSUPPORTED
        message = self._telemetry.requested(number)
        if message is None:
            return int(TEMPORARILY_REJECTED)
        self._send(message)
        return int(ACCEPTED)

    def _do_set_mode(self, main: int, sub: int, done: Done) -> None:
        mode = mode_of(main, sub)
        if mode is None:
            done(int(DENIED))
            return
        self._core.command_mode(mode, done)

    def _set_mode(self, message: Message) -> None:
        """The old SET_MODE message: no acknowledgement."""
        self._do_set_mode(message.custom_mode >> 16 & 0xFF, message.custom_mode >> 24 & 0xFF, lambda _: None)

    def _takeoff_height_m(self, altitude_m: float) -> float | None:
        """Height above home of the altitude in a take-off command; NaN leaves it to MIS_TAKEOFF_ALT."""
        if not math.isfinite(altitude_m):
            return None
        core = self._core
        return altitude_m - core.frames.to_geodetic(core.navigator.home_ned_m).altitude_m

    def _reposition(self, values: Parameters7) -> int:
        core = self._core
        if not (math.isfinite(values[4]) and math.isfinite(values[5]) and math.isfinite(values[6])):
            return int(DENIED)
        results: list[int] = []
        core.command_mode(Mode.HOLD, results.append)
        if results == [int(ACCEPTED)]:
            target = core.frames.geodetic_to_mission(GeodeticPoint(values[4], values[5], values[6]))
            core.navigator.reposition(target, values[3])
            if values[0] > 0.0:
                core.navigator.cruise_speed_m_s = values[0]
        return results[0] if results else int(TEMPORARILY_REJECTED)

    # -- setpoints ------------------------------------------------------------------------------------------------

    def _setpoint_local(self, message: Message) -> None:
        position = _taken((message.x, message.y, message.z), message.type_mask)
        body = message.coordinate_frame in _BODY_FRAMES
        if body:
            position = _NAN
        elif message.coordinate_frame != mavlink.MAV_FRAME_LOCAL_NED:
            return
        elif any(math.isfinite(value) for value in position):
            own = self._core.frames.to_local(self._core.estimate().position_ned_m)
            filled = tuple(value if math.isfinite(value) else mine for value, mine in zip(position, own, strict=True))
            north, east, down = self._core.frames.from_local((filled[0], filled[1], filled[2]))
            position = _where((north, east, down), position)
        self._accept(message, position, body)

    def _setpoint_global(self, message: Message) -> None:
        core, position = self._core, _NAN
        if not message.type_mask & 0b111:
            altitude_m = message.alt
            if message.coordinate_frame in (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT):
                altitude_m += core.frames.to_geodetic(core.navigator.home_ned_m).altitude_m
            point = GeodeticPoint(message.lat_int * 1e-7, message.lon_int * 1e-7, altitude_m)
            position = core.frames.geodetic_to_mission(point)
        self._accept(message, position, body=False)

    def _accept(self, message: Message, position_ned_m: Vector, body: bool) -> None:
        mask = message.type_mask
        if mask & 0x1FF == 0x1FF:
            return
        self._core.setpoint = OffboardSetpoint(
            self._core.t_s,
            position_ned_m,
            _taken((message.vx, message.vy, message.vz), mask >> 3),
            _taken((message.afx, message.afy, message.afz), mask >> 6),
            math.nan if mask & 1024 else message.yaw,
            math.nan if mask & 2048 else message.yaw_rate,
            body,
        )

    # -- parameters -----------------------------------------------------------------------------------------------

    def _param_value(self, name: str) -> Message:
        parameters = self._core.parameters
        return mavlink.MAVLink_param_value_message(
            name.encode(), parameters.wire_value(name), parameters.wire_type(name), len(parameters), parameters.index(name)
        )

    def _param_error(self, message: Message, error: int) -> None:
        self._send(
            mavlink.MAVLink_param_error_message(
                message.get_srcSystem(), message.get_srcComponent(), message.param_id.encode(), -1, error
            )
        )

    def _param_read(self, message: Message) -> None:
        parameters = self._core.parameters
        name = parameters.name_at(message.param_index) if message.param_index >= 0 else message.param_id
        if name is None or name not in parameters:
            self._param_error(message, _PARAM_DOES_NOT_EXIST)
        else:
            self._send(self._param_value(name))

    def _param_list(self, _: Message) -> None:
        self._to_list = list(self._core.parameters)

    def _param_set(self, message: Message) -> None:
        parameters, name = self._core.parameters, message.param_id
        if name not in parameters:
            self._param_error(message, _PARAM_DOES_NOT_EXIST)
        else:
            # A value of the wrong type changes nothing; the answer tells the value that stands.
            parameters.set_from_wire(name, message.param_value, message.param_type)
            self._send(self._param_value(name))

    # -- fence and mission upload ---------------------------------------------------------------------------------

    def _mission_count(self, message: Message) -> None:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        self._plans[message.mission_type] = []
        if message.count == 0:
            self._mission_ack(sender, message.mission_type)
            return
        self._upload = (*sender, message.mission_type, message.count)
        self._send(mavlink.MAVLink_mission_request_int_message(*sender, 0, message.mission_type))

    def _mission_item(self, message: Message) -> None:
        if self._upload is None or message.mission_type != self._upload[2]:
            return
        system, component, kind, count = self._upload
        items = self._plans[kind]
        if message.seq == len(items):
            items.append(message)
        if len(items) == count:
            self._upload = None
            self._mission_ack((system, component), kind)
        else:
            self._send(mavlink.MAVLink_mission_request_int_message(system, component, len(items), kind))

    def _mission_clear(self, message: Message) -> None:
        self._plans.pop(message.mission_type, None)
        self._mission_ack((message.get_srcSystem(), message.get_srcComponent()), message.mission_type)

    def _mission_list(self, message: Message) -> None:
        count = len(self._plans.get(message.mission_type, []))
        self._send(
            mavlink.MAVLink_mission_count_message(
                message.get_srcSystem(), message.get_srcComponent(), count, message.mission_type
            )
        )

    def _mission_request(self, message: Message) -> None:
        items = self._plans.get(message.mission_type, [])
        if message.seq < len(items):
            item = items[message.seq]
            item.target_system, item.target_component = message.get_srcSystem(), message.get_srcComponent()
            self._send(item)

    def _mission_ack(self, sender: tuple[int, int], kind: int) -> None:
        self._send(mavlink.MAVLink_mission_ack_message(*sender, mavlink.MAV_MISSION_ACCEPTED, kind))

    # -- time -----------------------------------------------------------------------------------------------------

    def _timesync(self, message: Message) -> None:
        if message.tc1 == 0:
            self._send(mavlink.MAVLink_timesync_message(int(self._core.t_s * 1e9), message.ts1))

    def _ping(self, message: Message) -> None:
        if message.target_system == 0:
            self._send(
                mavlink.MAVLink_ping_message(message.time_usec, message.seq, message.get_srcSystem(), message.get_srcComponent())
            )


def _taken(values: Vector, ignored: int) -> Vector:
    """NaN where the mask's three lowest bits say "ignore"."""
    return (
        math.nan if ignored & 1 else values[0],
        math.nan if ignored & 2 else values[1],
        math.nan if ignored & 4 else values[2],
    )


def _where(values: Vector, given: Vector) -> Vector:
    return (
        values[0] if math.isfinite(given[0]) else math.nan,
        values[1] if math.isfinite(given[1]) else math.nan,
        values[2] if math.isfinite(given[2]) else math.nan,
    )
