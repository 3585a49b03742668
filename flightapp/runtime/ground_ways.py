"""The ways of a mission planned on the ground: who finds none there needs not take off."""

from __future__ import annotations

import asyncio

import numpy as np

from flightapp.core.types import ObstacleSet
from flightapp.preflight.facts import WayFacts
from flightapp.runtime.rooms import Rooms

NOTHING_SEEN = ObstacleSet(0.0, np.zeros((0, 7)), np.zeros((0, 2)))


async def ways_from_the_ground(rooms: Rooms) -> tuple[WayFacts, ...]:
    """To the vehicle's station and home from there, past what is known; nothing where none is to be planned. In a thread."""
    station = rooms.vehicle.station
    if rooms.mission.ingress != "planned" or station is None:
        return ()
    return await asyncio.to_thread(_planned, rooms, station.north_m, station.east_m)


def _planned(rooms: Rooms, north_m: float, east_m: float) -> tuple[WayFacts, ...]:
    from flightapp.runtime.way_planner import WayPlanner  # compiled: loaded only where it is flown

    mission, start, ways = rooms.mission, rooms.vehicle.start, WayPlanner(rooms)
    down = -mission.height_of(rooms.vehicle)
    above_start, station = np.array((start.north_m, start.east_m, down)), np.array((north_m, east_m, down))
    planned = [ways.plan("ingress", above_start, station, NOTHING_SEEN)]
    if mission.way_home == "planned":
        home = np.array((start.north_m, start.east_m, -mission.return_height_of(rooms.vehicle)))
        planned.append(ways.plan("way home", station, home, NOTHING_SEEN))
    return tuple(WayFacts(way.trajectory is not None, way.text) for way in planned)
