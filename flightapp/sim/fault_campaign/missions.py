"""Variants of a mission: wind, more obstacles, a third pursuer."""

from __future__ import annotations

import math
import random

from pydantic import ValidationError

from flightapp.config.mission import Cylinder, Mission, Obstacles, Simulation, Start

WIND_MAX_M_S = 8.0
GUST_MAX_M_S = 1.5
MORE_TREES_MAX = 8
FREE_AROUND_STARTS_M = 5.0
FREE_BETWEEN_TREES_M = 4.0
"""Between surfaces: room to pass with the planner's margins."""
TRIES = 20


def vary(mission: Mission, source: random.Random) -> Mission:
    """`mission` with a wind, some more trees and perhaps one more pursuer, all by `source`."""
    mission = _with(mission, simulation=_simulation(mission.simulation, source))
    if source.random() < 0.5:
        mission = _with_pursuer(mission, source)
    for _ in range(source.randint(0, MORE_TREES_MAX)):
        mission = _with_tree(mission, source)
    return mission


def _simulation(simulation: Simulation, source: random.Random) -> Simulation:
    wind, towards = source.uniform(0.0, WIND_MAX_M_S), source.uniform(-math.pi, math.pi)
    changes = {
        "wind_north_m_s": wind * math.cos(towards),
        "wind_east_m_s": wind * math.sin(towards),
        "gust_m_s": source.uniform(0.0, GUST_MAX_M_S),
        "origin_offset_m": source.uniform(0.0, 1000.0),
    }
    return simulation.model_copy(update=changes)


def _with_pursuer(mission: Mission, source: random.Random) -> Mission:
    """One more pursuer like the first, where the mission has room for it."""
    pursuers = [one for one in mission.vehicles if one.role == "pursuer"]
    if not pursuers:
        return mission
    first, system_id = pursuers[0], max(one.system_id for one in mission.vehicles) + 1
    for _ in range(TRIES):
        north, east = first.start.north_m + source.uniform(-6.0, 6.0), first.start.east_m + source.uniform(-16.0, 16.0)
        if min(math.dist((north, east), (one.start.north_m, one.start.east_m)) for one in mission.vehicles) < 4.0:
            continue
        start = Start(north_m=north, east_m=east, heading_deg=first.start.heading_deg)
        added = first.model_copy(update={"name": f"p{system_id}", "system_id": system_id, "start": start})
        try:
            return _with(mission, vehicles=(*mission.vehicles, added))
        except ValidationError:
            continue
    return mission


def _with_tree(mission: Mission, source: random.Random) -> Mission:
    """One more tree at a free place of the flight volume; none where that is not found."""
    north_m, east_m = zip(*mission.flight_volume.vertices_m, strict=True)
    tall_m = max([9.0, *(one.height_m for one in mission.obstacles.cylinders)])
    for _ in range(TRIES):
        north, east = source.uniform(min(north_m), max(north_m)), source.uniform(min(east_m), max(east_m))
        radius = source.uniform(0.3, 1.0)
        if not _is_free(mission, north, east, radius):
            continue
        tree = Cylinder(north_m=north, east_m=east, radius_m=radius, height_m=min(tall_m, mission.return_height_m - 1.0))
        obstacles = Obstacles(cylinders=(*mission.obstacles.cylinders, tree), boxes=mission.obstacles.boxes)
        try:
            return _with(mission, obstacles=obstacles)
        except ValidationError:
            continue
    return mission


def _is_free(mission: Mission, north: float, east: float, radius: float) -> bool:
    starts = [(one.start.north_m, one.start.east_m, FREE_AROUND_STARTS_M) for one in mission.vehicles]
    trees = [(one.north_m, one.east_m, one.radius_m + FREE_BETWEEN_TREES_M) for one in mission.obstacles.cylinders]
    boxes = [
        (one.north_m, one.east_m, 0.5 * math.hypot(one.length_m, one.width_m) + FREE_BETWEEN_TREES_M)
        for one in mission.obstacles.boxes
    ]
    return all(math.dist((north, east), (n, e)) > room + radius for n, e, room in (*starts, *trees, *boxes))


def _with(mission: Mission, **changes: object) -> Mission:
    """A changed mission, validated as one from a file."""
    return Mission.model_validate({**{name: getattr(mission, name) for name in Mission.model_fields}, **changes})
