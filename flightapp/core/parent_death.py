"""Linux: have the kernel send this process a signal when its parent dies, so that nothing is left behind."""

from __future__ import annotations

import ctypes
import os
import signal

_PR_SET_PDEATHSIG = 1


def signal_on_parent_death(number: signal.Signals, parent_pid: int | None = None) -> None:
    """Ask for `number` on the parent's death; send it at once where `parent_pid` is gone already."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_PR_SET_PDEATHSIG, int(number), 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl(PR_SET_PDEATHSIG) failed")
    if parent_pid is not None and os.getppid() != parent_pid:
        os.kill(os.getpid(), number)
