"""The vehicle process's end of the deadman pipe."""

from __future__ import annotations

import os
import signal

ACTIVE = b"a"
"""Setpoints may be flowing: silence from now on means kill."""
CLIMBING = b"c"
"""As ACTIVE, in a mode that no failsafe of the autopilot's own ends: whoever finds this process dead must land the vehicle."""
LEFT = b"l"
"""This process ends by itself and leaves the vehicle in its climb: silence is harmless, but the vehicle must be landed."""
IDLE = b"i"
"""Nothing depends on this process: silence is harmless."""


class Heartbeat:
    """One byte a control period; without a pipe (a test, a tool) it does nothing."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor
        self.last = IDLE
        """What was told last."""
        if descriptor is not None:
            os.set_blocking(descriptor, False)

    def beat(self, stage: bytes) -> None:
        """Tell ACTIVE, CLIMBING, LEFT or IDLE."""
        self.last = stage
        if self._descriptor is None:
            return
        try:
            os.write(self._descriptor, stage)
        except BlockingIOError:
            return  # The pipe is full because the deadman is not reading; it will find plenty when it does.
        except BrokenPipeError:
            self._descriptor = None  # The deadman died: without it nobody may fly on.
            signal.raise_signal(signal.SIGTERM)
