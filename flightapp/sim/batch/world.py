"""The arrays of one episode and the two compiled calls on them: sense, advance."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Decision, ObstacleSet, VehicleState
from flightapp.planning.plane import segments
from flightapp.sim.batch.advance import advance
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.period import DOWN_M, keep_pose
from flightapp.sim.batch.records import (
    COLLIDED_WITH,
    frame_records,
    sensor_records,
    vehicle_records,
    world_record,
)
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.sensing import sense
from flightapp.sim.batch.surrounding import measure_encirclement
from flightapp.sim.batch.walls import cover_discs, edge_rows
from flightapp.sim.wind import STILL, drawn

NOTHING_UNSEEN = np.zeros((0, 2))


class World:
    """Truth of one episode: pursuers first, the evader last."""

    def __init__(self, scenario: Scenario, layout: Layout, wind_key: int, sensing_key: int, sees_walls: bool = False) -> None:
        """sees_walls: pursuers see the layout's polygons as discs along their edges."""
        moving = (layout.discs[:, 3:5] != 0.0).any(axis=1)
        self.discs = np.ascontiguousarray(np.concatenate((layout.discs[moving], layout.discs[~moving])))
        self._walls = edge_rows(layout.polygons)
        along_walls = cover_discs(layout.polygons)
        self._sensed = np.concatenate((self.discs, along_walls))
        self.record = world_record(scenario, layout, wind_key, sensing_key)
        self._air = STILL if scenario.wind.harmonic is None else drawn(scenario.wind.harmonic, wind_key)
        self.vehicles = vehicle_records(layout)
        self._frames = frame_records(scenario)
        self.record["walls"] = len(along_walls)
        self._sensors = sensor_records(scenario, sees_walls)
        area = layout.area
        self.area = np.array((area.north_min_m, area.north_max_m, area.east_min_m, area.east_max_m))
        self._sides = np.array([[*a, *b] for a, b in segments(layout.boundary)])
        count, rows = len(self.vehicles), len(self._sensed) + len(self.vehicles)
        latest = max(int(self._sensors["latency_steps"].max()), int(self.record["target_latency_steps"][0]))
        if scenario.sensing.kind == "depth":
            latest += 2 * scenario.sub_steps  # frames of the last control period, with the acceleration that led to them
        self.poses = np.zeros((latest + 1, count, 5))
        delay = int(self._frames["delay_steps"].max())
        self._commands = np.zeros((count, math.ceil(delay / scenario.sub_steps) + 1, 3))
        self._near = np.zeros((count, max(1, len(self.discs))), dtype=np.int64)
        self._counts = np.zeros(count, dtype=np.int64)
        self._views, self._found = np.zeros((rows, 3)), np.zeros((rows, 6))
        self._rows = np.zeros((count, rows, 7))
        self._sees_all_around = (self._sensors["half_view"] >= math.pi).tolist()
        self._latency_steps = self._sensors["latency_steps"].tolist()
        self._sub_steps, self._sub_step_s = scenario.sub_steps, scenario.sub_step_s
        self._states = np.zeros((2 * count, 3))
        self._states[::2, 0], self._states[::2, 1], self._states[::2, 2] = self.vehicles["n"], self.vehicles["e"], DOWN_M
        keep_pose(self.vehicles, self.poses, 0)
        measure_encirclement(self.record, self.vehicles, 0.0, 0.0)

    def states(self, t_s: float) -> list[VehicleState]:
        """True state of every vehicle, in arrays that stay as they are."""
        rows = list(self._states)
        yaws = self.vehicles["yaw"].tolist()
        return [VehicleState(t_s, rows[2 * i], rows[2 * i + 1], yaw) for i, yaw in enumerate(yaws)]

    def obstacles(self, tick: int) -> list[ObstacleSet]:
        """What every vehicle sees."""
        unseen = np.empty((len(self._counts), 2))
        sense(
            self.record,
            self._sensors,
            self._frames,
            self._sensed,
            self.area,
            self.poses,
            self._views,
            self._found,
            self._rows,
            self._counts,
            unseen,
        )
        seen = []
        for i, count in enumerate(self._counts.tolist()):
            step = max(0, tick * self._sub_steps - self._latency_steps[i])
            sectors = NOTHING_UNSEEN if self._sees_all_around[i] else unseen[i : i + 1]
            seen.append(ObstacleSet(step * self._sub_step_s, self._rows[i, :count].copy(), sectors))
        return seen

    def remove(self, index: int) -> None:
        """Take vehicle `index` out of the world: nothing touches it any more, and it counts for nothing."""
        self.vehicles[index]["gone"] = self._sensors[index]["gone"] = 1
        self.vehicles[index]["vn"] = self.vehicles[index]["ve"] = 0.0
        self._states = self._states.copy()
        self._states[2 * index + 1] = 0.0

    @property
    def target_seen(self) -> bool:
        """Whether `obstacles` found the evader in sight."""
        return bool(self.record["target_seen"][0])

    def advance(self, tick: int, decisions: list[Decision]) -> int:
        """Everything through control period `tick`: code of the event that ended the episode in it, or FLYING."""
        self._take(tick, decisions)
        self._states = np.empty_like(self._states)
        return advance(
            self.record,
            self.vehicles,
            self._frames,
            self._air,
            self._commands,
            self.discs,
            self._walls,
            self.area,
            self._sides,
            self.poses,
            self._near,
            self._counts,
            self._states,
        )

    def _take(self, tick: int, decisions: list[Decision]) -> None:
        """What is to be flown in the plane from control period `tick` on."""
        row = tick % self._commands.shape[1]
        for command, decision in zip(self._commands, decisions, strict=True):
            velocity = decision.velocity_ned_m_s
            command[row, 0], command[row, 1], command[row, 2] = velocity[0], velocity[1], decision.yaw_rad

    @property
    def collided_with(self) -> str:
        return COLLIDED_WITH[int(self.record["collided_with"][0])]
