"""The pilot, or a termination signal, at awkward moments: nobody is fought, and nobody is left in the air."""

from collections.abc import Sequence
from pathlib import Path

from flightapp.recording.reader import read_recording
from tests.runtime.one_vehicle import LAND, POSITION_CONTROL, OneVehicle, one_vehicle, until

TAKEOFF = 4 | 2 << 8


def pilot(folder: Path, when: str, *arguments: str) -> Sequence[str]:
    """The mock's pilot takes position control at `when`, and lands four seconds later."""
    script = folder / "pilot.toml"
    script.write_text(
        "faults = [\n"
        f'  {{ target = "mode", verb = "wrong", mode = "POSCTL", when = {{ {when} }} }},\n'
        '  { target = "mode", verb = "wrong", mode = "LAND", when = { mode = "POSCTL", height_above_m = 0.5, after_s = 4.0 } },\n'
        "]\n"
    )
    return "--scenario", str(script), *arguments


def assert_released(vehicle: OneVehicle, silent_after_s: float) -> None:
    """From the take-over on no mode command went out, and setpoints ended within `silent_after_s`."""
    until(lambda: vehicle.relay.mode() == POSITION_CONTROL, 90.0, "pilot", vehicle)
    taken_s = vehicle.relay.modes[-1][0]
    until(lambda: vehicle.relay.mode() == LAND, 20.0, "pilot's landing", vehicle)
    assert vehicle.process.wait(timeout=40) == 1
    late = [sent_s - taken_s for sent_s in vehicle.relay.setpoints_s if sent_s > taken_s + silent_after_s]
    assert late == []
    assert [sent_s for sent_s in vehicle.relay.mode_commands_s if sent_s > taken_s] == []
    phases = read_recording(vehicle.run / "e1.mcap").topic("/phase")
    assert phases.texts("phase")[-2:] == ["released", "done"]
    assert "has control" in phases.texts("reason")[-2]
    assert "fault_felt" in vehicle.mock_log.read_text()


# Where the news of a mode comes late it is harder; the same with news at once is flown on the virtual clock.
def test_the_pilot_takes_over_in_offboard_with_heartbeats_once_a_second_and_is_never_fought(tmp_path: Path) -> None:
    arguments = pilot(tmp_path, 'mode = "OFFBOARD", after_s = 6.0', "--slow-heartbeat")
    with one_vehicle(tmp_path, mock_arguments=arguments) as vehicle:
        assert_released(vehicle, silent_after_s=0.5)  # MAVSDK's own repeats included


def test_the_pilot_takes_over_during_take_off_with_heartbeats_once_a_second(tmp_path: Path) -> None:
    arguments = pilot(tmp_path, 'mode = "TAKEOFF", height_above_m = 0.8', "--slow-heartbeat")
    with one_vehicle(tmp_path, mock_arguments=arguments) as vehicle:
        assert_released(vehicle, silent_after_s=0.0)
        assert vehicle.relay.setpoints_s == []


def test_a_termination_during_take_off_brings_the_vehicle_down(tmp_path: Path) -> None:
    with one_vehicle(tmp_path, mock_arguments=("--slow-heartbeat",)) as vehicle:
        until(lambda: "phase takeoff" in (vehicle.run / "e1.log").read_text(), 90.0, "take-off", vehicle)
        vehicle.process.terminate()
        assert vehicle.process.wait(timeout=60) == 1
        recording = read_recording(vehicle.run / "e1.mcap")
        assert recording.complete
        assert recording.topic("/phase").texts("phase")[-2:] == ["land", "done"]
        assert '"event": "disarmed"' in vehicle.mock_log.read_text()
