"""The team plan of strategies that bring none: equal sectors around the evader, exchanged only for a gain that is worth it."""

from __future__ import annotations

import math
from collections.abc import Iterable

from flightapp.fleet.coordination.plan import Plan, Seat
from flightapp.fleet.coordination.scene import Scene
from flightapp.fleet.coordination.sectors import Division, divide, kept_bearings, turned
from flightapp.fleet.coordination.team_plan import Draft

PLAN_PERIOD_S = 0.2
EXCHANGE_GAIN_S = 0.5
EXCHANGE_GAIN_SHARE = 0.1
"""Of the cost: seats are exchanged for a gain above both."""
ARRIVAL_MAX_S = 120.0
"""What is said of a chase that hardly ever ends: an evader as fast as the pursuers is met after hours, or never."""


class SectorPlan:
    """It remembers nothing: the plan in force is enough to go on from."""

    period_s = PLAN_PERIOD_S
    leaderless_s = math.inf

    def __init__(self, ring_radius_m: float) -> None:
        self._ring_radius_m = ring_radius_m

    def note(self, now_s: float, scene: Scene) -> None:
        """Nothing to remember."""

    def draft(self, now_s: float, scene: Scene, before: Plan | None) -> Draft:
        return Draft(tuple(_seats(now_s, scene, self._ring_radius_m, self._division(scene, before))))

    def _division(self, scene: Scene, before: Plan | None) -> Division:
        """The one in force, turned with the pursuers, as long as another is not worth the exchange."""
        best = divide(scene, self._ring_radius_m)
        seats = {} if before is None else {seat.vehicle: seat.bearing_rad for seat in before.seats}
        bearings = kept_bearings(scene, seats)
        if bearings is None:
            return best
        kept = turned(scene, self._ring_radius_m, bearings)
        gain_s = kept.cost_s - best.cost_s
        return best if gain_s > max(EXCHANGE_GAIN_S, EXCHANGE_GAIN_SHARE * kept.cost_s) else kept


def _seats(now_s: float, scene: Scene, radius_m: float, division: Division) -> Iterable[Seat]:
    for pursuer, bearing, after in zip(scene.pursuers, division.bearings_rad, division.arrivals_s, strict=True):
        after_s = min(float(after), ARRIVAL_MAX_S)
        north = scene.north_m + scene.v_north_m_s * after_s + radius_m * math.cos(bearing)
        east = scene.east_m + scene.v_east_m_s * after_s + radius_m * math.sin(bearing)
        yield Seat(pursuer.name, float(bearing), north, east, now_s + after_s)
