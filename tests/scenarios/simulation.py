"""`flightapp sim` as a user starts it, and the processes it leaves (or does not leave) behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "missions/demo_two_pursuers.toml"
HOVER = ROOT / "missions/hover.toml"


@dataclass
class Simulation:
    """A running `flightapp sim --json`."""

    process: subprocess.Popen[str]
    run: Path
    output: Path
    errors: Path

    def summary(self) -> dict[str, Any]:
        return dict(json.loads(self.output.read_text()))

    def said(self) -> str:
        return self.errors.read_text()

    def phase(self, vehicle: str) -> str:
        """The newest phase that the vehicle's own log names."""
        log = self.run / f"{vehicle}.log"
        lines = log.read_text().splitlines() if log.exists() else []
        phases = [line.split("] phase ")[1].split()[0] for line in lines if "] phase " in line]
        return phases[-1] if phases else ""

    def processes(self) -> list[psutil.Process]:
        """Everything on this machine that works for this run, the launcher excepted."""
        return [process for process in processes_of(self.run) if process.pid != self.process.pid]

    def vehicle_process(self, vehicle: str) -> psutil.Process:
        """The process that flies `vehicle` (not its deadman)."""
        for process in self.processes():
            line = process.cmdline()
            if "flightapp.runtime.vehicle_process" in line and "flightapp.runtime.deadman" not in line and vehicle in line:
                return process
        raise AssertionError(f"no vehicle process of {vehicle}\n{self.said()}")

    def until(self, condition: Callable[[], bool], timeout_s: float, what: str) -> None:
        deadline = time.monotonic() + timeout_s
        while not condition():
            assert time.monotonic() < deadline, f"no {what} within {timeout_s} s\n{self.said()}"
            assert self.process.poll() is None, f"ended with {self.process.returncode} before {what}\n{self.said()}"
            time.sleep(0.02)

    def interrupt(self) -> None:
        """Ctrl-C."""
        self.process.send_signal(signal.SIGINT)


def processes_of(run: Path) -> list[psutil.Process]:
    """Everything on this machine that works for the run in this folder."""

    def belongs(process: psutil.Process) -> bool:
        try:
            return any(str(run) in part for part in process.cmdline())
        except (psutil.NoSuchProcess, psutil.AccessDenied):
            return False

    return [process for process in psutil.process_iter() if belongs(process)]


@contextmanager
def simulation(folder: Path, mission: Path = DEMO, *arguments: str) -> Iterator[Simulation]:
    """Start a run in `folder`; on leaving, everything that is left of it is killed."""
    folder.mkdir(exist_ok=True)
    run, output, errors = folder / "run", folder / "out.json", folder / "err.txt"
    with output.open("w") as out, errors.open("w") as err:
        process = subprocess.Popen(
            [sys.executable, "-m", "flightapp", "sim", str(mission), "--json", "--run", str(run), *arguments],
            stdout=out,
            stderr=err,
            text=True,
            cwd=ROOT,
            start_new_session=True,
        )
    running = Simulation(process, run, output, errors)
    try:
        yield running
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for left in running.processes():
            left.kill()


def flightapp(*arguments: str, folder: Path, check: bool = False) -> subprocess.CompletedProcess[str]:
    """A command that is expected to end soon, started in `folder`."""
    command: Sequence[str] = [sys.executable, "-m", "flightapp", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=60, check=check, env=environment)
