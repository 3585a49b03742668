"""The target: where it is by its own telemetry or, where that has ended, by what cameras saw of it last."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shapely.geometry import LineString, Point, Polygon

from flightapp.config.mission import Mission
from flightapp.watch.data_model_heard import Heard
from flightapp.watch.data_model_thresholds import Thresholds

LOOK_AHEAD_S = 600.0
STANDING_M_S = 0.1
TELEMETRY = "telemetry"


@dataclass(frozen=True, slots=True)
class Target:
    """Mission frame, m, north and east. What cameras tell has no speed."""

    name: str
    source: str
    """Its telemetry, or the vehicle whose camera saw it."""
    age_s: float
    north_m: float
    east_m: float
    speed_m_s: float | None
    boundary_distance_m: float
    """To the protected boundary; 0 inside a closed one."""
    boundary_time_s: float | None
    """Until it crosses on its present course at its present speed; None where that leads nowhere near it."""


def target_of(mission: Mission, heard: Heard, thresholds: Thresholds) -> Target | None:
    """None where the mission has no evader or nothing was heard of it."""
    name = next((vehicle.name for vehicle in mission.vehicles if vehicle.role == "evader"), None)
    if name is None:
        return None
    state = heard.states.get(name)
    seen = max(heard.sightings.items(), key=lambda item: item[1].t_s, default=None)
    if state is not None and (
        heard.now_s - state.t_s <= thresholds.lost_age_of_s(state) or seen is None or seen[1].t_s <= state.t_s
    ):
        place, velocity = state.position_ned_m[:2], state.velocity_ned_m_s[:2]
        age_s = max(0.0, heard.now_s - state.t_s)
        time_s = boundary_time_s(mission, place, velocity)
        return Target(name, TELEMETRY, age_s, *place, math.hypot(*velocity), boundary_distance_m(mission, place), time_s)
    if seen is None:
        return None
    vehicle, sighting = seen
    place, age_s = (sighting.north_m, sighting.east_m), max(0.0, heard.now_s - sighting.t_s)
    return Target(name, vehicle, age_s, *place, None, boundary_distance_m(mission, place), None)


def boundary_distance_m(mission: Mission, place_m: tuple[float, float]) -> float:
    """From (north, east) to the protected boundary."""
    return float(_boundary(mission).distance(Point(place_m)))


def boundary_time_s(mission: Mission, place_m: tuple[float, float], velocity_m_s: tuple[float, float]) -> float | None:
    """How long from (north, east) straight on at (north, east) velocity to the boundary; None where it is not met."""
    speed = math.hypot(*velocity_m_s)
    if speed < STANDING_M_S:
        return None
    end = (place_m[0] + velocity_m_s[0] * LOOK_AHEAD_S, place_m[1] + velocity_m_s[1] * LOOK_AHEAD_S)
    met = LineString((place_m, end)).intersection(_boundary(mission))
    return None if met.is_empty else float(met.distance(Point(place_m))) / speed


def _boundary(mission: Mission) -> LineString | Polygon:
    boundary = mission.boundary
    return Polygon(boundary.vertices_m) if boundary.closed else LineString(boundary.vertices_m)
