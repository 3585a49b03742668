"""Silence must mean silence: whatever stops the control loop, setpoints stop within 0.5 s and PX4's failsafe acts."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from flightapp.recording.reader import read_recording
from tests.runtime.one_vehicle import LAND, TAKEOFF, one_vehicle, until

HANGING = Path(__file__).with_name("hanging_vehicle.py")


@pytest.mark.parametrize(
    "blow",
    [
        pytest.param(signal.SIGUSR1, id="blocked event loop"),
        pytest.param(signal.SIGUSR2, id="call that holds the GIL"),
        pytest.param(signal.SIGSTOP, id="SIGSTOP"),
        pytest.param(signal.SIGKILL, id="SIGKILL"),
    ],
)
def test_setpoints_stop_within_half_a_second_and_the_failsafe_follows(tmp_path: Path, blow: signal.Signals) -> None:
    with one_vehicle(tmp_path, script=HANGING) as vehicle:
        vehicle.wait_for_offboard()
        victim = vehicle.vehicle_process()
        struck_s, struck_unix_s = time.monotonic(), time.time()
        victim.send_signal(blow)
        assert vehicle.process.wait(timeout=10) == 3
        until(lambda: vehicle.relay.mode() == LAND, 10.0, "failsafe landing", vehicle)
        assert vehicle.relay.setpoints_s[-1] - struck_s < 0.5
        changed_s = vehicle.relay.modes[-1][0]
        assert changed_s - struck_s < 0.5 + 1.0 + 1.5  # silence, COM_OF_LOSS_T, time to the next heartbeat
        assert has_ended(victim)
        recording = read_recording(vehicle.run / "e1.mcap")
        assert not recording.complete
        assert struck_unix_s - recording.topic("/setpoint").t_s[-1] < 0.5


def test_a_vehicle_whose_process_dies_in_the_climb_is_landed(tmp_path: Path) -> None:
    """No failsafe of PX4's own would: it would hold at the mission height until its battery is empty."""
    with one_vehicle(tmp_path) as vehicle:
        until(lambda: vehicle.relay.mode() == TAKEOFF, 90.0, "take-off", vehicle)
        vehicle.vehicle_process().send_signal(signal.SIGKILL)
        until(lambda: vehicle.relay.mode() == LAND, 30.0, "landing", vehicle)
        assert vehicle.process.wait(timeout=30) == 3


def test_without_the_deadman_mavsdk_goes_on_and_the_failsafe_never_acts(tmp_path: Path) -> None:
    """The unsafe twin: proves that the test above shows the deadman's work."""
    with one_vehicle(tmp_path, script=HANGING, deadman=False) as vehicle:
        vehicle.wait_for_offboard()
        struck_s = time.monotonic()
        vehicle.vehicle_process().send_signal(signal.SIGUSR1)
        until(
            lambda: bool(vehicle.relay.setpoints_s) and vehicle.relay.setpoints_s[-1] - struck_s > 2.5, 10.0, "repeats", vehicle
        )
        assert vehicle.relay.mode() != LAND


def test_the_vehicle_lands_when_the_deadman_itself_is_killed(tmp_path: Path) -> None:
    with one_vehicle(tmp_path) as vehicle:
        vehicle.wait_for_offboard()
        victim = vehicle.vehicle_process()
        os.kill(vehicle.process.pid, signal.SIGKILL)
        until(lambda: vehicle.relay.mode() == LAND, 5.0, "landing", vehicle)
        until(
            lambda: not victim.is_running() or victim.status() == psutil.STATUS_ZOMBIE,
            40.0,
            "end of the vehicle process",
            vehicle,
        )
        assert read_recording(vehicle.run / "e1.mcap").complete


def has_ended(process: psutil.Process) -> bool:
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


def run_under_the_deadman(code: str, timeout_s: float) -> tuple[int, float, str]:
    """Exit status, duration and words of the deadman over a child that runs `code` with the descriptor in `fd`."""
    prelude = "import os, sys, time; fd = int(sys.argv[sys.argv.index('--heartbeat-fd') + 1]); "
    started_s = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-m", "flightapp.runtime.deadman", str(timeout_s), sys.executable, "-c", prelude + code],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    return done.returncode, time.monotonic() - started_s, done.stderr


def test_silence_before_the_first_setpoint_is_harmless() -> None:
    status, _, _ = run_under_the_deadman("os.write(fd, b'i'); time.sleep(0.5); sys.exit(1)", 0.1)
    assert status == 1


@pytest.mark.parametrize(("told", "landed"), [("l", True), ("c", True), ("i", False), ("a", False)])
def test_only_a_vehicle_left_in_its_climb_is_landed_and_silence_does_not_kill_who_left_it(
    tmp_path: Path, told: str, landed: bool
) -> None:
    child = (
        "import os, sys, time; told = sys.argv[1]; os.write(int(sys.argv[-1]), told.encode()); time.sleep(0.4 * (told in 'li')); "
        "os._exit(0)"
    )
    last_resort = tmp_path / "landed"
    guard = "import sys; from flightapp.runtime.deadman import run_guarded; "
    guard += "sys.exit(run_guarded(sys.argv[3:], 0.1, [sys.executable, '-c', sys.argv[1], sys.argv[2]]))"
    touch = "import pathlib, sys; pathlib.Path(sys.argv[1]).touch()"
    command = [sys.executable, "-c", guard, touch, str(last_resort), sys.executable, "-c", child, told]
    assert subprocess.run(command, timeout=30, check=False).returncode == 0
    assert last_resort.exists() == landed


def test_a_termination_signal_ends_a_last_resort_that_waits(tmp_path: Path) -> None:
    waits = tmp_path / "waits"
    guard = "import sys; from flightapp.runtime.deadman import run_guarded; "
    guard += "sys.exit(run_guarded(sys.argv[3:], 5.0, [sys.executable, '-c', sys.argv[1], sys.argv[2]]))"
    resort = "import pathlib, sys, time; pathlib.Path(sys.argv[1]).touch(); time.sleep(60)"
    child = "import os, sys; os.write(int(sys.argv[-1]), b'l')"
    deadman = subprocess.Popen([sys.executable, "-c", guard, resort, str(waits), sys.executable, "-c", child])
    deadline_s = time.monotonic() + 20.0
    while not waits.exists() and time.monotonic() < deadline_s:
        time.sleep(0.02)
    assert waits.exists()
    deadman.terminate()
    try:
        assert deadman.wait(20.0) == 0
    finally:
        deadman.kill()


def test_silence_after_it_is_not() -> None:
    status, duration_s, words = run_under_the_deadman("os.write(fd, b'a'); time.sleep(20)", 0.1)
    assert status == 3
    assert duration_s < 10.0
    assert "silent for" in words


def test_a_crash_is_reported_as_a_fault() -> None:
    status, _, words = run_under_the_deadman("os.write(fd, b'a'); os.abort()", 5.0)
    assert status == 3
    assert "ended by itself" in words
