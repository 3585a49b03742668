"""Decides when a silent camera is started again, and says what is wrong meanwhile. No threads, no clock of its own."""

from __future__ import annotations

from collections.abc import Callable

BACK_OFF_S = (0.5, 1.0, 2.0, 4.0)
"""Pauses between attempts in a row; the last one repeats."""
START_TIMEOUT_S = 3.0
"""How long the first frame after a start may take."""


class StallWatch:
    """Call `step` a few times a second; it never raises what `restart` raises.

    restart: stops what is left and starts the camera again; raises where it cannot.
    label: what the sentences call the camera.
    """

    def __init__(self, label: str, restart: Callable[[], None], *, stall_timeout_s: float, started_s: float) -> None:
        self._label = label
        self._restart = restart
        self._stall_timeout_s = stall_timeout_s
        self._silent_since_s = started_s
        self._timeout_s = max(START_TIMEOUT_S, stall_timeout_s)
        self._arrived = 0
        self._attempts = 0
        self._next_attempt_s = started_s
        self._last_frame_s = started_s
        self._fault = ""
        self.restarts = 0

    def fault(self, arrived: int) -> str:
        """What is wrong; empty once frames have come again."""
        return self._fault if arrived == self._arrived else ""

    def step(self, now_s: float, arrived: int) -> None:
        """arrived: how many frames have come since the camera was opened."""
        if arrived != self._arrived:
            self._arrived = arrived
            self._silent_since_s = self._last_frame_s = now_s
            self._timeout_s = self._stall_timeout_s
            self._attempts = 0
            self._next_attempt_s = now_s
            self._fault = ""
        elif now_s - self._silent_since_s > self._timeout_s and now_s >= self._next_attempt_s:
            self._start_again(now_s)

    def _start_again(self, now_s: float) -> None:
        silence_s = now_s - self._last_frame_s
        self._next_attempt_s = now_s + BACK_OFF_S[min(self._attempts, len(BACK_OFF_S) - 1)]
        self._attempts += 1
        self._fault = f"{self._label}: no frame for {silence_s:.1f} s; being started again"
        try:
            self._restart()
        except Exception as error:  # Whatever a driver raises: the next attempt may succeed.
            self._fault = f"{self._label}: no frame for {silence_s:.1f} s and it cannot be started again: {error}"
            return
        self.restarts += 1
        self._silent_since_s = now_s
        self._timeout_s = max(START_TIMEOUT_S, self._stall_timeout_s)
