"""Two autopilots with one system id on one link: MAVLink cannot tell them apart, their clocks can."""

from __future__ import annotations

from collections import deque

DIFFERENT_S = 0.5
"""Transport delays vary by less; two autopilots are hardly ever switched on this close together."""
CHANGES_MIN = 4
WINDOW_S = 3.0


class TwinWatch:
    """Watches time since boot against arrival. A restart moves the difference once; two senders move it to and fro."""

    def __init__(self) -> None:
        self._offset_s: float | None = None
        self._changes_s: deque[float] = deque(maxlen=CHANGES_MIN)

    def note(self, boot_s: float, arrived_s: float) -> None:
        """One message of the autopilot, stamped `boot_s` after its boot."""
        offset_s = arrived_s - boot_s
        if self._offset_s is not None and abs(offset_s - self._offset_s) > DIFFERENT_S:
            self._changes_s.append(arrived_s)
        self._offset_s = offset_s

    def sign(self, t_s: float) -> str:
        """One sentence while there are two; empty otherwise."""
        changes = tuple(self._changes_s)
        if len(changes) < CHANGES_MIN or t_s - changes[0] > WINDOW_S:
            return ""
        return "telemetry of two autopilots with this system id is mixed: times since boot jump to and fro"
