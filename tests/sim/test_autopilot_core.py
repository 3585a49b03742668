"""Commander, failsafes and protocol of the mock autopilot, on a virtual clock."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
import pytest

from flightapp.core.geodesy import GeodeticPoint, geodetic_to_mission, geodetic_to_px4_local, mission_to_geodetic
from flightapp.sim.autopilot_estimator import Noise
from flightapp.sim.autopilot_frames import Frames
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.mavlink_dialect import mavlink
from flightapp.sim.multirotor import Wind
from tests.sim.virtual_mock import DATUM, POSITION_AND_VELOCITY, VirtualMock

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = range(5)


def hovering(*faults: dict[str, Any], **options: Any) -> VirtualMock:
    mock = VirtualMock(*faults, **options)
    mock.take_off()
    return mock


def test_take_off_reaches_the_parameter_height_and_holds() -> None:
    mock = hovering()
    mock.run(2.0)
    assert mock.core.mode is Mode.HOLD
    assert mock.core.vehicle.height_above_ground_m == pytest.approx(3.0, abs=0.2)
    assert mock.newest("EXTENDED_SYS_STATE").landed_state == mavlink.MAV_LANDED_STATE_IN_AIR


def test_an_extra_heartbeat_tells_each_change_at_once() -> None:
    mock = VirtualMock()
    mock.run(1.2)
    before = len(mock.all("HEARTBEAT"))
    mock.arm()
    mock.step()
    assert len(mock.all("HEARTBEAT")) == before + 1
    assert mock.newest("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def test_landing_disarms_two_seconds_after_it_was_detected() -> None:
    mock = hovering()
    assert mock.command(mavlink.MAV_CMD_NAV_LAND) == ACCEPTED
    landed_s = mock.run_until(lambda: mock.core.landed)
    disarmed_s = mock.run_until(lambda: not mock.core.armed)
    assert disarmed_s - landed_s == pytest.approx(2.0, abs=0.1)
    assert mock.core.mode is Mode.HOLD
    assert mock.arm() == ACCEPTED


def test_return_comes_home_and_lands() -> None:
    mock = hovering(parameters={"RTL_RETURN_ALT": 4.0, "RTL_DESCEND_ALT": 3.0})
    start = mock.core.navigator.home_ned_m
    mock.fly_offboard(3.0, 1.0)
    mock.run(4.0)
    mock.stream = None
    assert mock.mode(Mode.RTL) == ACCEPTED
    mock.run_until(lambda: not mock.core.armed, 60.0)
    assert math.dist(mock.core.vehicle.position_ned_m[:2], start[:2]) < 0.3


def test_return_climbs_to_its_height_and_not_beyond() -> None:
    mock = hovering(parameters={"RTL_RETURN_ALT": 10.0, "RTL_DESCEND_ALT": 5.0})
    mock.fly_offboard(5.0, 0.0)
    mock.run(6.0)
    mock.stream = None
    assert mock.mode(Mode.RTL) == ACCEPTED
    heights = []
    while mock.core.armed:
        mock.run(0.1)
        heights.append(mock.core.navigator.home_ned_m[2] - mock.core.vehicle.position_ned_m[2])
    assert 9.0 < max(heights) < 10.7


def test_disarming_in_the_air_is_denied_unless_forced() -> None:
    mock = hovering()
    assert mock.disarm() == DENIED
    assert mock.disarm(force=True) == ACCEPTED
    assert not mock.core.armed


def test_an_armed_vehicle_that_does_not_take_off_is_disarmed() -> None:
    mock = VirtualMock()
    mock.run(1.0)
    assert mock.arm() == ACCEPTED
    assert mock.run_until(lambda: not mock.core.armed) == pytest.approx(11.0, abs=0.1)


def test_offboard_needs_a_running_setpoint_stream() -> None:
    mock = hovering()
    assert mock.mode(Mode.OFFBOARD) == TEMPORARILY_REJECTED
    mock.send(mock.velocity(0, 0, 0))
    mock.run(0.6)
    assert mock.mode(Mode.OFFBOARD) == TEMPORARILY_REJECTED
    mock.send(mock.velocity(0, 0, 0))
    assert mock.mode(Mode.OFFBOARD) == ACCEPTED


@pytest.mark.parametrize(("action", "mode"), [(0, Mode.POSCTL), (1, Mode.ALTCTL), (3, Mode.RTL), (4, Mode.LAND), (5, Mode.HOLD)])
@pytest.mark.parametrize("loss_s", [0.5, 1.0])
def test_setpoint_loss_acts_after_the_parameter_time(action: int, mode: Mode, loss_s: float) -> None:
    mock = hovering(parameters={"COM_OBL_RC_ACT": action, "COM_OF_LOSS_T": loss_s})
    mock.fly_offboard(1.0)
    mock.run(2.0)
    mock.stream = None
    silent_s = mock.core.t_s
    assert mock.run_until(lambda: mock.core.mode is not Mode.OFFBOARD) - silent_s == pytest.approx(loss_s, abs=0.05)
    assert mock.core.mode is mode
    mock.run(0.05)
    assert mock.newest("HEARTBEAT").custom_mode == mode.custom_mode
    assert "Failsafe activated: No offboard signal" in mock.texts()


def test_it_returns_to_offboard_by_itself_when_setpoints_resume() -> None:
    mock = hovering()
    mock.fly_offboard(1.0)
    mock.run(1.0)
    stream, mock.stream = mock.stream, None
    mock.run(2.5)
    assert mock.core.mode is Mode.POSCTL
    assert mock.core.vehicle.velocity_ned_m_s[2] == pytest.approx(0.8, abs=0.1)
    mock.stream = stream
    mock.run(0.1)
    assert mock.core.mode is Mode.OFFBOARD


def test_after_a_failsafe_landing_the_mode_reads_offboard() -> None:
    mock = hovering(parameters={"COM_OBL_RC_ACT": 4})
    mock.fly_offboard()
    mock.run(0.5)
    mock.stream = None
    mock.run_until(lambda: not mock.core.armed, 30.0)
    assert mock.core.mode is Mode.OFFBOARD


def test_a_velocity_setpoint_is_flown_and_its_loss_of_meaning_brakes() -> None:
    mock = hovering()
    mock.fly_offboard(2.0, -1.0, 0.0, 1.2)
    mock.run(4.0)
    assert mock.core.vehicle.velocity_ned_m_s[:2] == pytest.approx((2.0, -1.0), abs=0.05)
    assert mock.core.vehicle.yaw_rad == pytest.approx(1.2, abs=0.02)
    mock.stream = mock.velocity(math.nan, math.nan, math.nan)
    mock.run(3.0)
    assert math.hypot(*mock.core.vehicle.velocity_ned_m_s) < 0.05
    assert mock.core.mode is Mode.OFFBOARD


def test_a_position_setpoint_is_in_the_local_frame() -> None:
    mock = hovering()
    local = mock.core.frames.to_local((8.0, 5.0, -4.0))
    mock.stream = mavlink.MAVLink_set_position_target_local_ned_message(
        0, 1, 1, mavlink.MAV_FRAME_LOCAL_NED, POSITION_AND_VELOCITY, *local, 0, 0, 0, 0, 0, 0, 0, 0
    )
    mock.send(mock.stream)
    assert mock.mode(Mode.OFFBOARD) == ACCEPTED
    mock.run(10.0)
    assert mock.core.vehicle.position_ned_m == pytest.approx((8.0, 5.0, -4.0), abs=0.05)
    reported = mock.newest("LOCAL_POSITION_NED")
    assert (reported.x, reported.y, reported.z) == pytest.approx(local, abs=0.05)


def test_body_velocity_and_yaw_rate() -> None:
    mock = hovering()
    mock.stream = mavlink.MAVLink_set_position_target_local_ned_message(
        0, 1, 1, mavlink.MAV_FRAME_BODY_NED, 1479, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0, 0.0
    )
    mock.send(mock.stream)
    assert mock.mode(Mode.OFFBOARD) == ACCEPTED
    mock.run(3.0)
    yaw = mock.core.vehicle.yaw_rad
    assert mock.core.vehicle.velocity_ned_m_s[:2] == pytest.approx((math.cos(yaw), math.sin(yaw)), abs=0.05)


def test_vertical_speed_is_limited_by_parameters() -> None:
    mock = hovering(parameters={"MPC_Z_VEL_MAX_UP": 1.0})
    mock.fly_offboard(down=-3.0)
    mock.run(3.0)
    assert mock.core.vehicle.velocity_ned_m_s[2] == pytest.approx(-1.0, abs=0.05)


def test_messages_for_another_vehicle_are_ignored() -> None:
    mock = VirtualMock(system_id=2)
    mock.run(1.0)
    assert mock.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, system_id=1) is None
    assert not mock.core.armed
    mock.send(mock.velocity(1, 0, 0))
    assert mock.core.setpoint is None
    assert mock.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, system_id=0) == ACCEPTED


def test_unknown_commands_and_messages_get_an_answer() -> None:
    mock = VirtualMock()
    mock.run(1.0)
    assert mock.command(mavlink.MAV_CMD_DO_PARACHUTE) == UNSUPPORTED
    assert mock.command(mavlink.MAV_CMD_REQUEST_MESSAGE, 12345) == UNSUPPORTED
    assert mock.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 12345, 1000) == FAILED
    assert mock.command(mavlink.MAV_CMD_DO_SET_MODE, 1, 9, 0) == DENIED
    assert mock.command(mavlink.MAV_CMD_DO_SET_MODE, 1, 3, 0) == TEMPORARILY_REJECTED


@pytest.mark.parametrize(
    "kind",
    ["AUTOPILOT_VERSION", "HOME_POSITION", "GPS_GLOBAL_ORIGIN", "SYS_STATUS", "EXTENDED_SYS_STATE", "ODOMETRY", "HEARTBEAT"],
)
def test_messages_come_on_request(kind: str) -> None:
    mock = VirtualMock()
    mock.run(1.0)
    mock.messages.clear()
    assert mock.command(mavlink.MAV_CMD_REQUEST_MESSAGE, getattr(mavlink, f"MAVLINK_MSG_ID_{kind}")) == ACCEPTED
    assert mock.all(kind)


def test_default_and_requested_rates() -> None:
    mock = VirtualMock()
    mock.run(1.0)
    mock.messages.clear()
    mock.run(4.0)
    assert len(mock.all("LOCAL_POSITION_NED")) == 200
    assert len(mock.all("ATTITUDE")) == 200
    assert len(mock.all("GLOBAL_POSITION_INT")) == 40
    assert len(mock.all("HEARTBEAT")) in (4, 5)
    number = mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED
    for asked_hz, given in ((10, 40), (100, 400), (250, 500)):
        assert mock.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, number, 1e6 / asked_hz) == ACCEPTED
        mock.messages.clear()
        mock.run(4.0)
        assert abs(len(mock.all("LOCAL_POSITION_NED")) - given) <= 1
    mock.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, number, -1)
    mock.messages.clear()
    mock.run(1.0)
    assert not mock.all("LOCAL_POSITION_NED")


def test_parameters_travel_bytewise() -> None:
    mock = VirtualMock()
    mock.send(mavlink.MAVLink_param_request_read_message(1, 1, b"COM_OBL_RC_ACT", -1))
    assert mock.newest("PARAM_VALUE").param_type == mavlink.MAV_PARAM_TYPE_INT32
    (wire,) = struct.unpack("<f", struct.pack("<i", 4))
    mock.send(mavlink.MAVLink_param_set_message(1, 1, b"COM_OBL_RC_ACT", wire, mavlink.MAV_PARAM_TYPE_INT32))
    assert mock.core.parameters["COM_OBL_RC_ACT"] == 4
    mock.send(mavlink.MAVLink_param_set_message(1, 1, b"COM_OF_LOSS_T", 0.5, mavlink.MAV_PARAM_TYPE_REAL32))
    assert mock.core.parameters["COM_OF_LOSS_T"] == 0.5
    mock.send(mavlink.MAVLink_param_set_message(1, 1, b"COM_OF_LOSS_T", 0.7, mavlink.MAV_PARAM_TYPE_INT32))
    assert mock.core.parameters["COM_OF_LOSS_T"] == 0.5
    mock.send(mavlink.MAVLink_param_request_read_message(1, 1, b"NO_SUCH_PARAM", -1))
    assert mock.newest("PARAM_ERROR").error == mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST
    mock.messages.clear()
    mock.send(mavlink.MAVLink_param_request_list_message(1, 1))
    mock.run(1.0)
    listed = mock.all("PARAM_VALUE")
    assert sorted(m.param_index for m in listed) == list(range(len(mock.core.parameters)))


def test_timesync_and_ping_are_answered() -> None:
    mock = VirtualMock()
    mock.run(0.5)
    mock.send(mavlink.MAVLink_timesync_message(0, 123456789))
    assert (mock.newest("TIMESYNC").tc1, mock.newest("TIMESYNC").ts1) == (500_000_000, 123456789)
    mock.send(mavlink.MAVLink_ping_message(7, 3, 0, 0))
    assert (mock.newest("PING").seq, mock.newest("PING").target_system) == (3, 245)


def test_gps_loss_is_unnoticed_for_five_seconds_then_descends() -> None:
    mock = hovering({"target": "gps", "verb": "off", "when": {"mode": "OFFBOARD", "after_s": 2.0}, "duration_s": 8.0})
    mock.fly_offboard(1.0)
    lost_s = mock.run_until(lambda: "fault_felt" in mock.fault_events())
    health = mavlink.MAV_SYS_STATUS_SENSOR_GPS
    mock.run(4.5)
    assert mock.core.mode is Mode.OFFBOARD
    assert mock.newest("SYS_STATUS").onboard_control_sensors_health & health
    assert mock.newest("LOCAL_POSITION_NED").vx == pytest.approx(1.0, abs=0.1)
    assert math.dist(mock.core.vehicle.velocity_ned_m_s[:2], (1.0, 0.0)) > 0.3
    assert mock.run_until(lambda: mock.core.mode is Mode.ALTCTL) - lost_s == pytest.approx(5.0, abs=0.2)
    mock.run(1.5)
    assert not mock.newest("SYS_STATUS").onboard_control_sensors_health & health
    assert mock.core.vehicle.velocity_ned_m_s[2] == pytest.approx(0.8, abs=0.1)
    mock.run_until(lambda: "fault_ended" in mock.fault_events())
    mock.run(1.0)
    assert mock.core.position_valid
    assert mock.core.mode is Mode.ALTCTL


def test_a_pilot_takes_over_and_keeps_the_vehicle() -> None:
    mock = hovering({"target": "mode", "verb": "stuck", "when": {"mode": "OFFBOARD", "after_s": 1.0}, "duration_s": 3.0})
    mock.fly_offboard(1.0)
    mock.run_until(lambda: mock.core.mode is Mode.POSCTL)
    assert mock.mode(Mode.OFFBOARD) == TEMPORARILY_REJECTED
    mock.run(2.5)
    assert mock.core.mode is Mode.POSCTL
    assert mock.core.vehicle.height_above_ground_m == pytest.approx(3.0, abs=0.4)
    mock.run_until(lambda: "fault_ended" in mock.fault_events())
    assert mock.mode(Mode.OFFBOARD) == ACCEPTED


def test_low_battery_acts_by_parameter() -> None:
    low = {"target": "battery", "verb": "wrong", "remaining": 0.06, "when": {"height_above_m": 2.0}}
    mock = VirtualMock(low, parameters={"COM_LOW_BAT_ACT": 2})
    mock.run(1.0)
    mock.arm()
    mock.mode(Mode.TAKEOFF)
    mock.run_until(lambda: mock.core.mode is Mode.LAND)
    mock.run_until(lambda: not mock.core.armed)
    assert "Critical battery level" in mock.texts()
    assert mock.arm() == TEMPORARILY_REJECTED
    mock.step()
    assert mock.newest("STATUSTEXT").text.startswith("Preflight Fail")


def test_fence_by_parameters() -> None:
    mock = hovering(parameters={"GF_MAX_HOR_DIST": 5.0, "GF_ACTION": 2})
    mock.fly_offboard(3.0)
    mock.run_until(lambda: mock.core.mode is Mode.HOLD)
    assert "Geofence exceeded" in [event.get("text") for event in mock.events]


def test_a_fence_upload_is_accepted_and_read_back() -> None:
    mock = VirtualMock()
    kind = mavlink.MAV_MISSION_TYPE_FENCE
    mock.send(mavlink.MAVLink_mission_count_message(1, 1, 3, kind))
    for index in range(3):
        assert mock.newest("MISSION_REQUEST_INT").seq == index
        item = (index, 0, mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, 0, 1, 3, 0, 0, 0, 473977000 + index, 85456000, 0)
        mock.send(mavlink.MAVLink_mission_item_int_message(1, 1, *item, kind))
    assert mock.newest("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED
    mock.send(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    assert mock.newest("MISSION_COUNT").count == 3
    mock.send(mavlink.MAVLink_mission_request_int_message(1, 1, 2, kind))
    assert mock.newest("MISSION_ITEM_INT").x == 473977002
    mock.send(mavlink.MAVLink_mission_clear_all_message(1, 1, kind))
    mock.send(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    assert mock.newest("MISSION_COUNT").count == 0


def test_reposition_flies_to_a_geodetic_point() -> None:
    mock = hovering()
    goal = mission_to_geodetic(DATUM, np.array([9.0, 1.0, -3.5]))
    values = (0.0, 0.0, 0.0, math.nan, round(goal.latitude_deg * 1e7), round(goal.longitude_deg * 1e7), goal.altitude_m)
    mock.send(mavlink.MAVLink_command_int_message(1, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_REPOSITION, 0, 0, *values))
    assert mock.newest("COMMAND_ACK").result == ACCEPTED
    mock.run(12.0)
    assert mock.core.vehicle.position_ned_m == pytest.approx((9.0, 1.0, -3.5), abs=0.1)


def test_the_frames_agree_with_the_exact_conversions() -> None:
    origin = GeodeticPoint(47.3981, 8.5449, 491.0)
    frames = Frames(DATUM, origin)
    for position in ((0.0, 0.0, 0.0), (15.0, -19.0, -3.0), (400.0, -250.0, -20.0), (410.0, -262.0, -20.0)):
        exact = mission_to_geodetic(DATUM, np.array(position))
        assert geodetic_to_mission(DATUM, frames.to_geodetic(position)) == pytest.approx(position, abs=1e-3)
        assert frames.to_local(position) == pytest.approx(tuple(geodetic_to_px4_local(origin, exact)), abs=1e-3)
        assert frames.from_local(frames.to_local(position)) == pytest.approx(position, abs=1e-3)


def test_the_same_seed_sends_the_same_bytes() -> None:
    def flight(seed: int) -> bytes:
        faults = ({"target": "telemetry", "verb": "garbage", "at_s": 6.0, "duration_s": 2.0},)
        mock = VirtualMock(*faults, noise=Noise(), wind=Wind(1.0, 0.5, 1.0), seed=seed)
        mock.take_off()
        mock.fly_offboard(1.0, 1.0)
        mock.run(4.0)
        return mock.sent

    assert flight(4) == flight(4)
    assert flight(4) != flight(5)
