"""One pursuer flown on the virtual clock, its evader and its teammate played: the terminal phase for little computing time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flightapp.core.types import Array
from flightapp.fleet.messages import SharedState, encode_state, state_key
from flightapp.sim.virtual.fleet import VirtualFleet

STATE_PERIOD_S = 0.05
TREE_M = (4.0, 0.2, 0.5)
"""North, east, radius."""


class Played:
    """A vehicle that exists as its shared states only."""

    def __init__(self, name: str, role: str, system_id: int) -> None:
        self.name = name
        self.is_silent = False
        self.clock_ahead_s = 0.0
        self._due_s = -math.inf
        self._state = SharedState(
            vehicle=name,
            role=role,
            sequence=0,
            sent_s=0.0,
            t_s=0.0,
            position_ned_m=(0.0, 0.0, 0.0),
            velocity_ned_m_s=(0.0, 0.0, 0.0),
            yaw_rad=0.0,
            airborne=True,
            phase="ready",
            mode="played",
            outcome=None,
            eta_s=None,
            target_distance_m=None,
            clearance_m=None,
            link_age_s=None,
            mission="",
            system_id=system_id,
        )

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
        first = self._state.sequence == 0
        north, east, down = (0.0, 0.0, 0.0) if first else (moved / elapsed_s).tolist()
        self._due_s = now_s + STATE_PERIOD_S
        self._state = replace(
            self._state,
            sequence=self._state.sequence + 1,
            sent_s=now_s + self.clock_ahead_s,
            t_s=now_s + self.clock_ahead_s,
            position_ned_m=position_ned_m,
            velocity_ned_m_s=(north, east, down),
            mission=next(iter(fleet.vehicles.values())).rooms.mission_digest,
        )
        if not self.is_silent:
            fleet.network.publish(self.name, state_key(fleet.mission.fleet, self.name), encode_state(self._state))


def evader_path(t_s: float) -> tuple[float, float, float]:
    """To and fro behind the tree, 1.2 m/s at most."""
    return 6.5 + 0.5 * math.sin(0.5 * t_s), 0.2 + 2.0 * math.sin(0.5 * t_s), -2.5
