"""Does the fence contain every start and every height of the mission?"""

from __future__ import annotations

from shapely import Point, Polygon

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "fence"
REASON = "a vehicle that starts outside is pushed back or landed at once"


def judge(facts: Facts) -> tuple[Result, ...]:
    mission, volume = facts.mission, facts.mission.flight_volume
    polygon = Polygon(volume.vertices_m)
    outside = [one.name for one in mission.vehicles if not polygon.contains(Point(one.start.north_m, one.start.east_m))]
    if outside:
        found = f"starts outside: {', '.join(outside)}"
        return (Result(NAME, Level.FAILED, found, REASON, "move the starts, or widen flight_volume.vertices_m"),)
    heights = {one.name: mission.height_of(one) for one in mission.vehicles}
    wrong = [name for name, height in heights.items() if not volume.height_min_m < height < volume.height_max_m]
    if wrong:
        found = f"mission height outside the band: {', '.join(wrong)}"
        return (Result(NAME, Level.FAILED, found, REASON, "correct flight_volume.height_min_m, height_max_m or the heights"),)
    starts = [Point(one.start.north_m, one.start.east_m) for one in mission.vehicles]
    nearest_m = min(polygon.exterior.distance(start) for start in starts)
    return (Result(NAME, Level.PASSED, f"contains every start, the nearest {nearest_m:.0f} m inside", REASON),)
