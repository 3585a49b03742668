"""One pursuer flown on the virtual clock, its evader and its teammate played: the terminal phase for little computing time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import zenoh

from flightapp.core.types import Array
from flightapp.fleet.messages.codec import Header, encode
from flightapp.fleet.messages.intent import INTENT, Intent
from flightapp.fleet.messages.keys import key
from flightapp.fleet.messages.state import STATE, State
from flightapp.sim.virtual.fleet import VirtualFleet

STATE_PERIOD_S = 0.05
PRIORITY = zenoh.Priority.DATA
TREE_M = (4.0, 0.2, 0.5)
"""North, east, radius."""


class Played:
    """A vehicle that exists as its shared states only."""

    def __init__(self, name: str, role: str, system_id: int) -> None:
        self.name = name
        self.is_silent = False
        self.clock_ahead_s = 0.0
        self._due_s = -math.inf
        self._sequence = 0
        self._state = State(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, airborne=True, phase="ready", outcome=None)
        self._intent = Intent(role, "", system_id, "played", None, None, None, None, None, ())

    @property
    def position_ned_m(self) -> Array:
        return np.array(self._state.position_ned_m)

    def play(self, fleet: VirtualFleet, position_ned_m: tuple[float, float, float]) -> None:
        """Be at `position_ned_m` now, and say so where it is time to."""
        now_s = fleet.clock.now_s()
        if now_s < self._due_s:
            return
        elapsed_s = now_s - self._state.t_s + self.clock_ahead_s
        moved = np.subtract(position_ned_m, self._state.position_ned_m)
        first = self._sequence == 0
        north, east, down = (0.0, 0.0, 0.0) if first else (moved / elapsed_s).tolist()
        self._due_s = now_s + STATE_PERIOD_S
        self._sequence += 1
        header = Header(self.name, self._sequence, now_s + self.clock_ahead_s)
        self._state = replace(self._state, t_s=header.sent_s, position_ned_m=position_ned_m, velocity_ned_m_s=(north, east, down))
        intent = replace(self._intent, mission=next(iter(fleet.vehicles.values())).rooms.mission_digest)
        if not self.is_silent:
            for name, content in (("intent", encode(INTENT, intent, header)), ("state", encode(STATE, self._state, header))):
                fleet.network.publish(self.name, key(fleet.mission.fleet, self.name, name), content, PRIORITY)


def evader_path(t_s: float) -> tuple[float, float, float]:
    """To and fro behind the tree, 1.2 m/s at most."""
    return 6.5 + 0.5 * math.sin(0.5 * t_s), 0.2 + 2.0 * math.sin(0.5 * t_s), -2.5
