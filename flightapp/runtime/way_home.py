"""The way home: to above the own start, at the own return height."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import ObstacleSet, VehicleState
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.way_planner import PlannedWay, WayPlanner


class WayHome:
    """What `way_home = "planned"` flies, and what it falls back on."""

    def __init__(self, rooms: Rooms) -> None:
        mission, start = rooms.mission, rooms.vehicle.start
        self.ways = WayPlanner(rooms)
        self._goal = self.ways.within(np.array((start.north_m, start.east_m, -mission.return_height_of(rooms.vehicle))))

    def plan(self, own: VehicleState, seen: ObstacleSet, attempt: int = 0) -> PlannedWay:
        """From where the vehicle is."""
        return self.ways.plan("way home", own.position_ned_m, self._goal, seen, attempt)

    def is_return_free(self, own: VehicleState, seen: ObstacleSet) -> bool:
        """Whether the autopilot's own return, straight up to the return height and straight home, keeps clear."""
        here = own.position_ned_m
        above = np.array((here[0], here[1], min(here[2], self._goal[2])))
        return self.ways.is_clear(seen, here, above, np.array((self._goal[0], self._goal[1], above[2])))
