"""Autopilot boot time -> fleet time, without asking the autopilot anything.

Every message with a boot stamp arrives some delay after it was true; the smallest (arrival - boot) seen lately is the
offset with the least delay in it. The estimate may rise slowly, so that it follows a drifting autopilot clock, and
starts anew when the autopilot restarts (boot time runs backwards).
"""

from __future__ import annotations

DRIFT_ALLOWED = 1e-4
"""Seconds per second by which two crystals may drift apart."""


class BootClock:
    """Minimum filter over arrival - boot time."""

    def __init__(self) -> None:
        self._offset_s: float | None = None
        self._boot_s = 0.0

    def to_fleet_s(self, boot_s: float, arrived_s: float) -> float:
        """Fleet time at which a datum with boot stamp `boot_s`, arrived at `arrived_s`, was true."""
        candidate = arrived_s - boot_s
        if self._offset_s is None or boot_s < self._boot_s - 1.0:
            self._offset_s = candidate
        else:
            self._offset_s = min(candidate, self._offset_s + DRIFT_ALLOWED * max(0.0, boot_s - self._boot_s))
        self._boot_s = boot_s
        return boot_s + self._offset_s
