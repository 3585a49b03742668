"""What happens when the strategy breaks, the autopilot refuses, or the link dies: the vehicle comes down, and it is told."""

import time
from pathlib import Path

import numpy as np

from flightapp.recording.reader import Recording, read_recording
from tests.runtime.one_vehicle import LAND, OneVehicle, one_vehicle, until

RETURN = 4 | 5 << 8
BREAKING = Path(__file__).with_name("breaking_vehicle.py")


def recording_of(vehicle: OneVehicle) -> Recording:
    return read_recording(vehicle.run / "e1.mcap")


def scenario(folder: Path, fault: str) -> tuple[str, str]:
    path = folder / "faults.toml"
    path.write_text(f"faults = [ {{ {fault} }} ]\n")
    return "--scenario", str(path)


# A strategy that raises is flown on the virtual clock: tests/sim/virtual/test_stories_in_flight.py.
def test_a_setpoint_that_is_not_finite_never_reaches_the_autopilot(tmp_path: Path) -> None:
    with one_vehicle(tmp_path, script=BREAKING, script_arguments=("not-finite",)) as vehicle:
        vehicle.wait_for_offboard()
        until(lambda: vehicle.relay.mode() == RETURN, 20.0, "return", vehicle)
        assert vehicle.process.wait(timeout=60) == 3
        recording = recording_of(vehicle)
        assert "not finite" in str([message["acting"] for message in recording.topic("/setpoint").messages])
        assert recording.topic("/phase").texts("outcome")[-1] == "fault"
        told = [event["data"]["state"] for event in recording.topic("/event").messages if event["name"] == "failsafe"]
        assert told == ["HOLD", "RETURN"]
        flown = np.array(vehicle.relay.velocities_m_s)
        assert np.isfinite(flown).all()
        assert flown[:, 0].max() > 2.0  # it flew before the strategy broke
        assert abs(flown[-1, 0]) < 1.1
        assert np.linalg.norm(recording.topic("/own").vectors("position_ned_m")[-1, :2]) < 1.0, "it is home"


def test_a_strategy_that_never_returns_is_killed_by_the_deadman(tmp_path: Path) -> None:
    with one_vehicle(tmp_path, script=BREAKING, script_arguments=("endless",)) as vehicle:
        vehicle.wait_for_offboard()
        assert vehicle.process.wait(timeout=20) == 3
        ended_s = time.monotonic()
        until(lambda: vehicle.relay.mode() == LAND, 10.0, "failsafe landing", vehicle)
        assert vehicle.relay.setpoints_s[-1] <= ended_s
        assert "control loop silent" in (vehicle.run / "e1.log").read_text()


def test_refused_arming_is_a_fault_with_the_autopilots_own_reason(tmp_path: Path) -> None:
    with one_vehicle(tmp_path, mock_arguments=scenario(tmp_path, 'target = "arming", verb = "off", at_s = 0.0')) as vehicle:
        assert vehicle.process.wait(timeout=60) == 3
        reasons = " ".join(recording_of(vehicle).topic("/event").texts("text"))
        assert "autopilot refused 'arm'" in reasons
        assert "Preflight Fail" in reasons
        assert vehicle.relay.setpoints_s == []


def test_a_dead_link_ends_the_process_so_that_the_failsafe_can_act(tmp_path: Path) -> None:
    fault = 'target = "link_down", verb = "off", when = { mode = "OFFBOARD", after_s = 2.0 }'
    with one_vehicle(tmp_path, mock_arguments=scenario(tmp_path, fault)) as vehicle:
        vehicle.wait_for_offboard()
        assert vehicle.process.wait(timeout=90) == 3
        reasons = " ".join(recording_of(vehicle).topic("/event").texts("text"))
        assert "autopilot link lost" in reasons
        until(lambda: '"mode": "LAND"' in vehicle.mock_log.read_text(), 10.0, "failsafe landing", vehicle)
