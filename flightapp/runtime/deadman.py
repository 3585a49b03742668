"""Silence must mean silence: the process outside the vehicle process that ends it when its control loop stops.

MAVSDK repeats the last offboard setpoint from a native thread at 20 Hz, also while our interpreter hangs, so PX4 would
never notice. The deadman reads one byte a control period from a pipe. While the vehicle process says that setpoints may
be flowing or that the vehicle is armed, silence of `timeout_s` means SIGKILL; the repeats stop with the process and PX4's own
offboard-loss failsafe takes over. Returning or landing the autopilot goes on with the mode it is in.
A vehicle process that dies in its climb, or ends there because the link is lost, where PX4 would go on to HOLD for ever, is
followed by `vehicle.last_resort`, which lands the vehicle as soon as it is heard. The deadman imports nothing that can hang, does
not talk to the autopilot itself, and reads the monotonic clock itself: it must not depend on anything of the process that it
watches.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from types import FrameType

from flightapp.runtime.heartbeat import CLIMBING, IDLE, LEFT

EXIT_FAULT = 3


def run_guarded(command: Sequence[str], timeout_s: float, last_resort: Sequence[str] = ()) -> int:
    """Run `command` (given `--heartbeat-fd N`) under the deadman; its exit status, or 3 when it had to be killed.

    last_resort: a command that lands the vehicle, run after a death in the climb and where the vehicle was left in it.

    SIGTERM and SIGINT are passed on, so that the vehicle process lands and closes its recording; a last resort is ended by them.
    """
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # A lost terminal must not end a flight; the child inherits this.
    read_end, write_end = os.pipe()
    told = child = subprocess.Popen([*command, "--heartbeat-fd", str(write_end)], pass_fds=[write_end])
    os.close(write_end)

    def forward(_number: int, _frame: FrameType | None) -> None:
        told.send_signal(signal.SIGTERM)

    signal.signal(signal.SIGTERM, forward)
    signal.signal(signal.SIGINT, forward)
    silence_s, stage = _watch(read_end, timeout_s)
    if silence_s is not None:
        child.kill()
        status = _report(f"deadman: control loop silent for {silence_s * 1e3:.0f} ms; vehicle process killed, the autopilot acts")
        child.wait()
    else:
        status = child.wait()
        if not 0 <= status <= EXIT_FAULT:
            status = _report(f"vehicle process ended by itself with status {status}")
    if stage in (CLIMBING, LEFT) and last_resort:
        told = subprocess.Popen(last_resort)
        told.wait()
    return status


def _watch(descriptor: int, timeout_s: float) -> tuple[float | None, bytes]:
    """Length of the silence that is too long, None when the child closed its end (it ended); and what it told last."""
    stage = IDLE
    last = time.monotonic()
    while True:
        left = None if stage in (IDLE, LEFT) else max(0.0, timeout_s - (time.monotonic() - last))
        ready, _, _ = select.select([descriptor], [], [], left)
        now = time.monotonic()
        if not ready:
            return now - last, stage
        beats = os.read(descriptor, 4096)
        if not beats:
            return None, stage
        stage = beats[-1:]
        last = now


def _report(sentence: str) -> int:
    with contextlib.suppress(OSError):  # A terminal that does not take the sentence must not hold the deadman.
        os.set_blocking(sys.stderr.fileno(), False)
        os.write(sys.stderr.fileno(), f"{sentence}\n".encode())
    return EXIT_FAULT


def main() -> None:
    """`python -m flightapp.runtime.deadman TIMEOUT_S [--autopilot URL SYSTEM_ID] COMMAND...`: what `flightapp fly` becomes."""
    timeout_s, command, last_resort = float(sys.argv[1]), sys.argv[2:], []
    if command[:1] == ["--autopilot"]:
        last_resort = [sys.executable, "-m", "flightapp.vehicle.last_resort", *command[1:3]]
        command = command[3:]
    sys.exit(run_guarded(command, timeout_s, last_resort))


if __name__ == "__main__":
    main()
