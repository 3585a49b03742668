"""The real vehicle process, made to hang on request: SIGUSR1 blocks its event loop, SIGUSR2 blocks the interpreter.

Run as a script with the arguments of `flightapp.runtime.vehicle_process`.
"""

import ctypes
import signal
import sys
import time

from flightapp.runtime.vehicle_process import main

HANG_S = 60


def block_the_event_loop(_number: int, _frame: object) -> None:
    time.sleep(HANG_S)


def hold_the_gil(_number: int, _frame: object) -> None:
    ctypes.PyDLL(None).sleep(HANG_S)  # PyDLL, unlike CDLL, keeps the GIL during the call


if __name__ == "__main__":
    signal.signal(signal.SIGUSR1, block_the_event_loop)
    signal.signal(signal.SIGUSR2, hold_the_gil)
    sys.exit(main())
