"""The mock as a process, flown by the real MAVSDK; and its command line."""

from __future__ import annotations

import contextlib
import json
import math
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mavsdk.plugins.action import ActionError, ActionResult
from mavsdk.plugins.geofence.geofence import FenceType, Geofence, GeofenceData, Point, Polygon
from mavsdk.plugins.info.info import Info
from mavsdk.plugins.mavlink_direct.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.offboard import OffboardError, OffboardResult, VelocityNedYaw
from mavsdk.plugins.param import ParamError, ParamResult
from mavsdk.plugins.telemetry import FlightMode

from flightapp.core.geodesy import GeodeticPoint, mission_to_geodetic
from flightapp.sim.mock_autopilot import main
from tests.sim.mavsdk_pilot import Pilot, connected
from tests.sim.mock_process import MockProcess, free_udp_port, mock_autopilot, wait_until

LOW_FLIGHT = {"MIS_TAKEOFF_ALT": 1.5, "RTL_RETURN_ALT": 1.5, "RTL_DESCEND_ALT": 1.5, "COM_DISARM_LAND": 0.5}
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def parked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[MockProcess, Pilot]]:
    """A mock that stays on the ground, with a connected MAVSDK."""
    with mock_autopilot(tmp_path_factory.mktemp("parked")) as mock, connected(mock.url) as pilot:
        pilot.wait_ready()
        yield mock, pilot


def test_a_whole_flight(tmp_path: Path) -> None:
    with mock_autopilot(tmp_path, parameters=LOW_FLIGHT) as mock, connected(mock.url) as pilot:
        pilot.arm_and_take_off(1.5)
        pilot.start_offboard(1.5, -0.5, 0.0, 45.0)
        reached = pilot.wait(lambda: math.dist(mock.truth().velocity_ned_m_s[:2], (1.5, -0.5)) < 0.15, 5.0, "velocity")
        assert reached
        pilot.wait(lambda: abs(pilot.newest["attitude_euler"].yaw_deg - 45.0) < 3.0, 5.0, "yaw")
        told = pilot.newest["position_velocity_ned"].velocity
        assert (told.north_m_s, told.east_m_s) == pytest.approx((1.5, -0.5), abs=0.3)
        pilot.action.hold()
        pilot.wait_mode(FlightMode.HOLD)
        pilot.wait(lambda: math.hypot(*mock.truth().velocity_ned_m_s) < 0.2, 5.0, "stopped")
        pilot.action.return_to_launch()
        pilot.wait_mode(FlightMode.RETURN_TO_LAUNCH)
        pilot.wait(lambda: math.dist(mock.truth().position_ned_m[:2], (0.0, 0.0)) < 1.0, 10.0, "home")
        pilot.action.land()
        pilot.wait_mode(FlightMode.LAND)
        with pytest.raises(ActionError):
            pilot.action.disarm()
        pilot.wait(lambda: not pilot.newest["in_air"] and not pilot.newest["armed"], 10.0, "landed and disarmed")
        assert mock.truth().on_ground
        assert {"Takeoff detected", "Landing detected"} <= set(pilot.status_texts)


def test_setpoint_loss_is_seen_as_a_failsafe_mode_and_ends_by_itself(tmp_path: Path) -> None:
    scenario = '[[faults]]\ntarget = "link_up"\nverb = "off"\nwhen = { mode = "OFFBOARD", after_s = 0.5 }\nduration_s = 2.0\n'
    parameters = {**LOW_FLIGHT, "COM_OF_LOSS_T": 0.5, "COM_OBL_RC_ACT": 5}
    with mock_autopilot(tmp_path, scenario=scenario, parameters=parameters) as mock, connected(mock.url) as pilot:
        pilot.arm_and_take_off(1.5)
        pilot.start_offboard(0.5)
        pilot.wait_mode(FlightMode.HOLD)
        assert pilot.system.is_connected()
        wait_until(lambda: mock.events("fault_ended"), 5.0, "link back")
        pilot.offboard.set_velocity_ned(VelocityNedYaw(0.5, 0.0, 0.0, 0.0))
        pilot.wait_mode(FlightMode.OFFBOARD)
        began, felt = mock.events("fault_began")[0]["t_s"], mock.events("fault_felt")[0]["t_s"]
        failed = next(event["t_s"] for event in mock.events("mode") if event["reason"] == "offboard setpoints lost")
        assert felt - began < 0.2
        # 0.5 s without a setpoint; MAVSDK repeats it every 50 ms.
        assert 0.4 < failed - began < 0.7


def test_an_rc_pilot_takes_over(tmp_path: Path) -> None:
    scenario = '[[faults]]\ntarget = "mode"\nverb = "stuck"\nwhen = { mode = "OFFBOARD", after_s = 0.5 }\n'
    with mock_autopilot(tmp_path, scenario=scenario, parameters=LOW_FLIGHT) as mock, connected(mock.url) as pilot:
        pilot.arm_and_take_off(1.5)
        pilot.start_offboard(0.5)
        pilot.wait_mode(FlightMode.POSCTL)
        pilot.offboard.set_velocity_ned(VelocityNedYaw(0.5, 0.0, 0.0, 0.0))
        with pytest.raises(OffboardError) as refusal:
            pilot.offboard.start()
        assert refusal.value.result == OffboardResult.COMMAND_DENIED
        assert mock.events("fault_felt")


def test_position_is_in_the_own_local_frame(tmp_path: Path) -> None:
    mission = ROOT / "missions" / "demo_two_pursuers.toml"
    arguments = ("--mission", str(mission), "--vehicle", "p2", "--profile", str(ROOT / "profiles" / "sim.toml"))
    with mock_autopilot(tmp_path, *arguments) as mock, connected(mock.url, system_id=2) as pilot:
        pilot.wait_ready()
        assert pilot.system.get_system_id() == 2
        truth = mock.truth()
        assert truth.position_ned_m == pytest.approx((0.0, 8.0, 0.0), abs=1e-6)
        local = pilot.newest["position_velocity_ned"].position
        assert math.hypot(local.north_m, local.east_m) > 20.0
        point = mission_to_geodetic(GeodeticPoint(47.3977, 8.5456, 488.0), truth.position_ned_m)
        assert pilot.newest["position"].latitude_deg == pytest.approx(point.latitude_deg, abs=2e-6)
        assert pilot.newest["position"].absolute_altitude_m == pytest.approx(488.0, abs=0.3)


def test_parameters(parked: tuple[MockProcess, Pilot]) -> None:
    parameters = parked[1].param
    assert parameters.get_param_int("COM_OBL_RC_ACT") == 0
    parameters.set_param_int("COM_OBL_RC_ACT", 4)
    assert parameters.get_param_int("COM_OBL_RC_ACT") == 4
    parameters.set_param_int("COM_FLTMODE1", -1)
    assert parameters.get_param_int("COM_FLTMODE1") == -1
    parameters.set_param_float("COM_OF_LOSS_T", 0.5)
    assert parameters.get_param_float("COM_OF_LOSS_T") == pytest.approx(0.5)
    with pytest.raises(ParamError) as refusal:
        parameters.get_param_int("NO_SUCH_PARAM")
    assert refusal.value.result == ParamResult.DOES_NOT_EXIST
    with pytest.raises(ParamError) as refusal:
        parameters.get_param_float("COM_OBL_RC_ACT")
    assert refusal.value.result == ParamResult.WRONG_TYPE
    everything = parameters.get_all_params()
    assert {"MPC_XY_VEL_MAX", "RTL_RETURN_ALT"} <= {parameter.name for parameter in everything.float_params}


def test_take_off_altitude_and_version(parked: tuple[MockProcess, Pilot]) -> None:
    pilot = parked[1]
    pilot.action.set_takeoff_altitude(4.0)
    assert pilot.action.get_takeoff_altitude() == pytest.approx(4.0)
    assert Info(pilot.system).get_version().flight_sw_major == 1


def test_rates_are_accepted(parked: tuple[MockProcess, Pilot]) -> None:
    telemetry = parked[1].telemetry
    telemetry.set_rate_position_velocity_ned(20.0)
    telemetry.set_rate_attitude_euler(50.0)
    telemetry.set_rate_in_air(5.0)
    telemetry.set_rate_health(2.0)


def test_a_fence_is_uploaded(parked: tuple[MockProcess, Pilot]) -> None:
    fence = Geofence(parked[1].system)
    corners = [Point(47.398, 8.545), Point(47.398, 8.546), Point(47.397, 8.546)]
    fence.upload_geofence(GeofenceData(polygons=[Polygon(points=corners, fence_type=FenceType.INCLUSION)], circles=[]))
    fence.clear_geofence()


def test_offboard_without_setpoints_is_refused(parked: tuple[MockProcess, Pilot]) -> None:
    acks = send_and_collect(parked[1], command=176, parameters=(1.0, 6.0), target_system=1)
    wait_until(lambda: acks, 3.0, "acknowledgement")
    assert acks[0]["result"] == 1


def test_commands_to_another_vehicle_are_ignored(parked: tuple[MockProcess, Pilot]) -> None:
    pilot = parked[1]
    ignored = send_and_collect(pilot, command=400, parameters=(1.0, 0.0), target_system=9)
    answered = send_and_collect(pilot, command=31000, parameters=(0.0, 0.0), target_system=1)
    wait_until(lambda: any(ack["command"] == 31000 for ack in answered), 3.0, "acknowledgement of the later command")
    assert [ack["result"] for ack in answered if ack["command"] == 31000] == [3]
    assert not [ack for ack in ignored if ack["command"] == 400]
    assert not parked[0].events("armed")


def send_and_collect(pilot: Pilot, *, command: int, parameters: tuple[float, float], target_system: int) -> list[dict[str, Any]]:
    """Send a raw COMMAND_LONG; acknowledgements arrive in the list."""
    direct = MavlinkDirect(pilot.system)
    acks: list[dict[str, Any]] = []
    direct.subscribe_message("COMMAND_ACK", lambda message, _: acks.append(json.loads(message.fields_json)))
    fields = {"target_system": target_system, "target_component": 1, "command": command, "confirmation": 0}
    fields |= {f"param{index}": value for index, value in enumerate((*parameters, 0.0, 0.0, 0.0, 0.0, 0.0), 1)}
    direct.send_message(
        MavlinkMessage(
            "COMMAND_LONG", 1, 191, target_system_id=target_system, target_component_id=1, fields_json=json.dumps(fields)
        )
    )
    return acks


def test_arming_refused_by_the_scenario(tmp_path: Path) -> None:
    scenario = '[[faults]]\ntarget = "arming"\nverb = "off"\nat_s = 0.0\n'
    with mock_autopilot(tmp_path, scenario=scenario) as mock, connected(mock.url) as pilot:
        pilot.wait_ready()
        with pytest.raises(ActionError) as refusal:
            pilot.action.arm()
        assert refusal.value.result == ActionResult.COMMAND_DENIED
        pilot.wait(lambda: any(text.startswith("Preflight Fail") for text in pilot.status_texts), 3.0, "status text")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--param", "COM_OF_LOS_T=1"], "did you mean COM_OF_LOSS_T?"),
        (["--param", "COM_OBL_RC_ACT=0.5"], "is an integer"),
        (["--send-to", "14540"], "is not HOST:PORT"),
        (["--origin", "47.4,8.5"], "is not LATITUDE,LONGITUDE,ALTITUDE"),
        (["--system-id", "0"], "is not a system id"),
        (["--vehicle", "p1"], "belong together"),
        (["--mission", "nowhere.toml", "--vehicle", "p1"], "nowhere.toml: no such file"),
        (["--mission", str(ROOT / "missions" / "demo_two_pursuers.toml"), "--vehicle", "p9"], "it has p1, p2, e1"),
        (["--scenario", "nowhere.toml"], "nowhere.toml: no such file"),
        (["--truth", "/no/such/folder/truth"], "--truth /no/such/folder/truth: cannot be written"),
        (["--duration-s", "-1"], "--duration-s"),
        (["--speed", "3"], "unrecognized arguments"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_2(capsys: pytest.CaptureFixture[str], arguments: list[str], expected: str) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert expected in error
    assert error.count("\n") == 1


def test_it_ends_cleanly_on_a_signal_and_tells_what_was_never_felt(tmp_path: Path) -> None:
    scenario = '[[faults]]\ntarget = "gps"\nverb = "off"\nwhen = { height_above_m = 90.0 }\n'
    with mock_autopilot(tmp_path, scenario=scenario, port=free_udp_port()) as mock:
        mock.process.send_signal(signal.SIGTERM)
        assert mock.process.wait(5.0) == 0
        assert mock.events("fault_not_felt")[0]["fault"] == "gps off"
        assert mock.events()[-1]["event"] == "stopped"


def test_events_go_to_standard_output_by_default() -> None:
    command = [
        sys.executable,
        "-m",
        "flightapp.sim.mock_autopilot",
        "--duration-s",
        "0.2",
        "--send-to",
        f"127.0.0.1:{free_udp_port()}",
    ]
    run = subprocess.run(command, capture_output=True, text=True, timeout=20.0, check=True)
    assert [json.loads(line)["event"] for line in run.stdout.splitlines()] == ["started", "stopped"]


def test_help_shows_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    with contextlib.suppress(SystemExit):
        main(["--help"])
    assert "examples:" in capsys.readouterr().out
