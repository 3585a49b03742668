"""Start a mock autopilot as a process on a free port, for tests against the real MAVSDK.

with mock_autopilot(tmp_path, parameters={"MIS_TAKEOFF_ALT": 2.0}) as mock:
    mavsdk.add_any_connection_with_handle(mock.url)
    ... mock.truth() ... mock.events("fault_felt")
"""

from __future__ import annotations

import contextlib
import json
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.sim.truth import Truth, TruthReader


def free_udp_port() -> int:
    """A UDP port of 127.0.0.1 that was free a moment ago."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_until(holds: Callable[[], Any], deadline_s: float, what: str) -> Any:
    """The first true value of `holds()`; AssertionError names `what` when none came in time."""
    end_s = time.monotonic() + deadline_s
    while time.monotonic() < end_s:
        value = holds()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f"not within {deadline_s} s: {what}")


@dataclass(frozen=True)
class MockProcess:
    """A running mock: MAVSDK listens on `url`; truth and events are read from files."""

    process: subprocess.Popen[bytes]
    port: int
    truth_path: Path
    log_path: Path

    @property
    def url(self) -> str:
        return f"udpin://127.0.0.1:{self.port}"

    def truth(self) -> Truth:
        """The newest true state."""
        reader = TruthReader(self.truth_path)
        try:
            # None also where the writer was interrupted in the middle of a write.
            state: Truth = wait_until(reader.read, 5.0, "true state")
            return state
        finally:
            reader.close()

    def events(self, kind: str | None = None) -> list[dict[str, Any]]:
        """The events so far, of one kind or all."""
        lines = self.log_path.read_text(encoding="utf-8").splitlines()
        events = [json.loads(line) for line in lines if line.endswith("}")]
        return [event for event in events if kind in (None, event["event"])]


@contextlib.contextmanager
def mock_autopilot(
    folder: Path,
    *arguments: str,
    scenario: str | None = None,
    parameters: Mapping[str, float] | None = None,
    port: int | None = None,
    name: str = "mock",
) -> Iterator[MockProcess]:
    """Run a mock that sends to a free port; `scenario` is the text of a fault script."""
    port = free_udp_port() if port is None else port
    truth_path, log_path = folder / f"{name}.truth", folder / f"{name}.jsonl"
    command = [sys.executable, "-m", "flightapp.sim.mock_autopilot", "--send-to", f"127.0.0.1:{port}", "--die-with-parent"]
    command += ["--truth", str(truth_path), "--log", str(log_path), *arguments]
    for parameter, value in (parameters or {}).items():
        command += ["--param", f"{parameter}={value}"]
    if scenario is not None:
        script = folder / f"{name}-faults.toml"
        script.write_text(scenario, encoding="utf-8")
        command += ["--scenario", str(script)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    try:
        wait_until(lambda: process.poll() is not None or (log_path.exists() and log_path.stat().st_size), 15.0, "mock started")
        if process.poll() is not None:
            assert process.stderr is not None
            raise AssertionError(f"the mock ended with {process.returncode}: {process.stderr.read().decode()}")
        yield MockProcess(process, port, truth_path, log_path)
    finally:
        process.terminate()
        try:
            process.wait(5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
