"""Silence must mean silence: the process outside the vehicle process that ends it when its control loop stops.

MAVSDK repeats the last offboard setpoint from a native thread at 20 Hz, also while our interpreter hangs, so PX4 would
never notice. The deadman reads one byte a control period from a pipe. While the vehicle process says that setpoints may
be flowing or that the vehicle is armed, silence of `timeout_s` means SIGKILL; the repeats stop with the process and PX4's own
offboard-loss failsafe takes over. Outside OFFBOARD (take-off, return, landing) the autopilot goes on with the mode it is in.
The deadman imports nothing that can hang, never talks to the autopilot, and reads the monotonic clock itself: it must not
depend on anything of the process that it watches.
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

from flightapp.runtime.heartbeat import ACTIVE

EXIT_FAULT = 3


def run_guarded(command: Sequence[str], timeout_s: float) -> int:
    """Run `command` (given `--heartbeat-fd N`) under the deadman; its exit status, or 3 when it had to be killed.

    SIGTERM and SIGINT are passed on, so that the vehicle process lands and closes its recording.
    """
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # A lost terminal must not end a flight; the child inherits this.
    read_end, write_end = os.pipe()
    child = subprocess.Popen([*command, "--heartbeat-fd", str(write_end)], pass_fds=[write_end])
    os.close(write_end)

    def forward(_number: int, _frame: FrameType | None) -> None:
        child.send_signal(signal.SIGTERM)

    signal.signal(signal.SIGTERM, forward)
    signal.signal(signal.SIGINT, forward)
    silence_s = _watch(read_end, timeout_s)
    if silence_s is None:
        status = child.wait()
        return status if 0 <= status <= EXIT_FAULT else _report(f"vehicle process ended by itself with status {status}")
    child.kill()
    child.wait()
    return _report(f"deadman: control loop silent for {silence_s * 1e3:.0f} ms; vehicle process killed, the autopilot acts")


def _watch(descriptor: int, timeout_s: float) -> float | None:
    """Length of the silence that is too long, or None when the child closed its end (it ended)."""
    active = False
    last = time.monotonic()
    while True:
        left = max(0.0, timeout_s - (time.monotonic() - last)) if active else None
        ready, _, _ = select.select([descriptor], [], [], left)
        now = time.monotonic()
        if not ready:
            return now - last
        beats = os.read(descriptor, 4096)
        if not beats:
            return None
        active = beats[-1:] == ACTIVE
        last = now


def _report(sentence: str) -> int:
    with contextlib.suppress(OSError):  # A terminal that does not take the sentence must not hold the deadman.
        os.set_blocking(sys.stderr.fileno(), False)
        os.write(sys.stderr.fileno(), f"{sentence}\n".encode())
    return EXIT_FAULT


def main() -> None:
    """`python -m flightapp.runtime.deadman TIMEOUT_S COMMAND...`: what `flightapp fly` becomes."""
    sys.exit(run_guarded(sys.argv[2:], float(sys.argv[1])))


if __name__ == "__main__":
    main()
