"""Who has control: the app knows which flight modes it asked for, and any other mode is somebody else's."""

from __future__ import annotations

from flightapp.core.clock import Clock
from flightapp.vehicle.autopilot import Autopilot

SETTLING_S = 0.3
"""From an acknowledged mode command to the first heartbeat that is believed to show its effect."""


class Authority:
    """Any mode that the app did not ask for means that the pilot, or a failsafe of the autopilot, has control."""

    def __init__(self, autopilot: Autopilot, clock: Clock) -> None:
        self._autopilot = autopilot
        self._clock = clock
        self._own_modes: frozenset[str] = frozenset()
        """Flight modes that this app asked for; empty while it is not in control."""
        self._settling: tuple[float, frozenset[str]] | None = None
        """(time, modes): from the first heartbeat after that time on, only these modes are the app's own."""

    @property
    def is_held(self) -> bool:
        """True while the app is in control, as far as it asked for it."""
        return bool(self._own_modes)

    @property
    def is_settled(self) -> bool:
        """True once the mode that is reported can be the one that was asked for last."""
        return self._settling is None

    @property
    def is_own_mode(self) -> bool:
        """True where the reported mode is one that the app asked for."""
        return self._autopilot.status().flight_mode in self._own_modes

    def take(self, *modes: str) -> None:
        """The autopilot acknowledged `modes`; the mode it had counts as the app's own until a heartbeat can show the new one."""
        present = self._autopilot.status().flight_mode
        self._own_modes = frozenset((*modes, *self._own_modes, present))
        self._settling = (self._clock.now_s() + SETTLING_S, frozenset(modes))

    def give_up(self) -> None:
        """Somebody else has control."""
        self._own_modes, self._settling = frozenset(), None

    def settle(self) -> None:
        """Called often: from the first heartbeat on that can show the new mode, the old one is not the app's any more."""
        if self._settling is not None and self._autopilot.status().heartbeat_s > self._settling[0]:
            self._own_modes, self._settling = self._settling[1], None
