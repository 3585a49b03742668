"""What a virtual flight came out with, judged by the true states."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle

PURSUIT = "pursue"


@dataclass(slots=True)
class Figures:
    """Smallest distances while somebody pursues, as the report of a real-time run has them."""

    outcome: str | None = None
    capture_time_s: float | None = None
    min_obstacle_clearance_m: float | None = None
    """Of a pursuer's body."""
    min_separation_m: float | None = None
    """Of two pursuers' centres."""
    min_target_distance_m: float | None = None

    def plain(self) -> dict[str, object]:
        return asdict(self)


class Referee:
    """Watches a fleet: give `watch` to `fly_virtual`."""

    def __init__(self) -> None:
        self._began_s: float | None = None
        self._ended_s: float | None = None
        self._clearance_m = self._separation_m = self._target_m = math.inf

    def watch(self, fleet: VirtualFleet) -> None:
        """After every step."""
        pursuers = [one for one in fleet.vehicles.values() if one.vehicle.role == "pursuer"]
        if not any(one.loop.phase == PURSUIT for one in pursuers):
            if self._began_s is not None and self._ended_s is None:
                self._ended_s = fleet.clock.now_s()
            return
        if self._began_s is None:
            self._began_s = fleet.clock.now_s()
        evaders = [one for one in fleet.vehicles.values() if one.vehicle.role == "evader"]
        for index, one in enumerate(pursuers):
            north, east, down = one.position_ned_m.tolist()
            body_m = one.rooms.limits.body_radius_m
            self._clearance_m = min(self._clearance_m, fleet.world.signed_distance_m(north, east, down) - body_m)
            self._separation_m = min((self._separation_m, *(_apart_m(one, other) for other in pursuers[:index])))
            self._target_m = min((self._target_m, *(_apart_m(one, evader) for evader in evaders)))

    def figures(self, fleet: VirtualFleet) -> Figures:
        """When the flight is over."""
        outcomes = {str(one.outcome) for one in fleet.vehicles.values() if one.outcome is not None}
        began_s, ended_s = self._began_s, self._ended_s
        captured = outcomes == {"captured"} and began_s is not None and ended_s is not None
        return Figures(
            outcome=outcomes.pop() if len(outcomes) == 1 else ", ".join(sorted(outcomes)) or None,
            capture_time_s=ended_s - began_s if captured and began_s is not None and ended_s is not None else None,
            min_obstacle_clearance_m=_finite(self._clearance_m),
            min_separation_m=_finite(self._separation_m),
            min_target_distance_m=_finite(self._target_m),
        )


def _apart_m(one: VirtualVehicle, other: VirtualVehicle) -> float:
    return float(np.linalg.norm((one.position_ned_m - other.position_ned_m)[:2]))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
