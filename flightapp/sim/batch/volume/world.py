"""The world of one episode with heights."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Decision, ObstacleSet
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.volume.advance import DOWN, DOWN_RATE, TOP, advance_in_space
from flightapp.sim.batch.volume.table import Volume
from flightapp.sim.batch.world import World


class VolumeWorld(World):
    """Vehicles see all discs in range with their heights; what they see of each other is as in the plane."""

    def __init__(self, scenario: Scenario, volume: Volume, layout: Layout, wind_key: int, sensing_key: int) -> None:
        super().__init__(scenario, layout, wind_key, sensing_key)
        self._heights = np.zeros((len(self.vehicles), 3))
        self._heights[:-1, DOWN], self._heights[-1, DOWN] = -volume.pursuer_height_m, -volume.evader_height_m
        vehicles = [scenario.pursuers] * scenario.pursuers.count + [scenario.evader]
        self._rates = np.array([(-one.climb_rate_max_m_s, one.sink_rate_max_m_s) for one in vehicles])
        fastest = float(np.abs(self._rates).max())
        self._climb = np.array((fastest, volume.climb_acceleration_m_s2, volume.climb_response_s))
        self._wanted = np.zeros(self._commands.shape[:2])
        self._tell()

    def obstacles(self, tick: int) -> list[ObstacleSet]:
        """As in the plane, with the heights of what stands: without noise the place tells which disc it is. Others keep none."""
        seen = super().obstacles(tick)
        for one in seen:
            is_it = (one.discs[:, None, :3] == self.discs[None, :, :3]).all(axis=2)
            is_known, which = is_it.any(axis=1), is_it.argmax(axis=1) if len(self.discs) else np.zeros(0, int)
            one.discs[is_known, TOP:] = self.discs[which[is_known], TOP:]
        return seen

    def advance(self, tick: int, decisions: list[Decision]) -> int:
        """Everything through control period `tick`: code of the event that ended the episode in it, or FLYING."""
        self._take(tick, decisions)
        down = [float(decision.velocity_ned_m_s[2]) for decision in decisions]
        self._wanted[:, tick % self._wanted.shape[1]] = np.clip(down, self._rates[:, 0], self._rates[:, 1])
        outcome = advance_in_space(
            self.record,
            self.vehicles,
            self._frames,
            self._heights,
            self._climb,
            self._wanted,
            self._air,
            self._commands,
            self.discs,
            self.area,
            self._sides,
            self.poses,
            self._near,
            self._counts,
        )
        self._tell()
        return outcome

    def _tell(self) -> None:
        """The states, in arrays that stay as they are."""
        vehicles = self.vehicles
        self._states = np.empty((2 * len(vehicles), 3))
        self._states[::2] = np.column_stack((vehicles["n"], vehicles["e"], self._heights[:, DOWN]))
        self._states[1::2] = np.column_stack((vehicles["vn"], vehicles["ve"], self._heights[:, DOWN_RATE]))
