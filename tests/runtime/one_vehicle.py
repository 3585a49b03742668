"""One vehicle process with its mock autopilot, and a relay between them that measures."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.sim.fleet_files import ReservedPorts, prepare
from tests.runtime.mavlink_relay import MavlinkRelay

ROOT = Path(__file__).parents[2]
OFFBOARD = 6
TAKEOFF = 4 | 2 << 8
LAND = 4 | 6 << 8
POSITION_CONTROL = 3


@dataclass
class OneVehicle:
    """Handles of the running pieces."""

    relay: MavlinkRelay
    process: subprocess.Popen[str]
    """The deadman, or the vehicle process itself where there is none."""
    run: Path
    mock_log: Path

    def vehicle_process(self) -> psutil.Process:
        children = psutil.Process(self.process.pid).children()
        return children[0] if children else psutil.Process(self.process.pid)

    def wait_for_offboard(self) -> None:
        until(lambda: self.relay.mode() == OFFBOARD and len(self.relay.setpoints_s) > 50, 90.0, "OFFBOARD", self)


def until(condition: Callable[[], bool], timeout_s: float, what: str, vehicle: OneVehicle | None = None) -> None:
    """Wait for `condition`; fail with what the vehicle process said."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline:
            said = (vehicle.run / "e1.log").read_text() if vehicle is not None else ""
            raise AssertionError(f"no {what} within {timeout_s} s\n{said}")
        time.sleep(0.01)


@contextmanager
def one_vehicle(
    folder: Path,
    *,
    deadman: bool = True,
    mock_arguments: Sequence[str] = (),
    script: Path | None = None,
    script_arguments: Sequence[str] = (),
) -> Iterator[OneVehicle]:
    """Start mock, relay and vehicle process for missions/hover.toml; end them whatever happens."""
    mission_path = ROOT / "missions/hover.toml"
    loaded, profile = load_mission(mission_path), load_profile(ROOT / "profiles/sim.toml")
    run = folder / "run"
    run.mkdir()
    ports = ReservedPorts(2)
    (files,) = prepare(loaded, profile, run, folder, ports.numbers)
    relay = MavlinkRelay(files.mavlink_port)
    relay.start()
    mock_log = folder / "mock.jsonl"
    mock = subprocess.Popen(
        [
            *(sys.executable, "-m", "flightapp.sim.mock_autopilot", "--mission", str(mission_path), "--vehicle", "e1"),
            *("--send-to", f"127.0.0.1:{relay.mock_port}", "--truth", str(files.truth), "--log", str(mock_log)),
            *(
                "--param",
                "COM_OBL_RC_ACT=4",
                "--param",
                "COM_RC_OVERRIDE=3",
                "--param",
                "COM_LOW_BAT_ACT=3",
                "--die-with-parent",
                *mock_arguments,
            ),
        ],
        stdout=subprocess.DEVNULL,
    )
    process_path = [str(script), *script_arguments] if script else ["-m", "flightapp.runtime.vehicle_process"]
    child = [sys.executable, *process_path]
    child += ["--mission", str(mission_path), "--profile", str(files.profile), "--vehicle", "e1", "--run", str(run)]
    guard = [sys.executable, "-m", "flightapp.runtime.deadman", str(profile.control.deadman_timeout_s)]
    guard += ["--autopilot", load_profile(files.profile).autopilot.connection_url, str(loaded.vehicle("e1").system_id)]
    with (run / "e1.log").open("w") as log:
        process = subprocess.Popen([*guard, *child] if deadman else child, stderr=log, stdout=log, text=True, cwd=ROOT)
    vehicle = OneVehicle(relay, process, run, mock_log)
    try:
        yield vehicle
    finally:
        for victim in (*psutil.Process(process.pid).children(), process) if process.poll() is None else ():
            victim.kill()
        process.wait()
        mock.terminate()
        mock.wait()
        relay.stop()
        ports.release()
