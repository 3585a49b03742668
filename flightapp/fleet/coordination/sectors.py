"""The division of the circle around the evader among pursuers: equal sectors, so assigned that the last one arrives soonest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from flightapp.core.bearing import wrapped_rad
from flightapp.core.types import Array
from flightapp.fleet.coordination.arrival import arrival_times_s, detours_m
from flightapp.fleet.coordination.scene import Scene

TURN_STEP_RAD = math.radians(6.0)
MEAN_SHARE = 0.1
"""Of the mean arrival in the cost, so that the others do not stroll where only the last one counts."""
PASSING_M = 0.9
"""Between an obstacle's surface and the middle of a pursuer that passes it."""


@dataclass(frozen=True, slots=True)
class Division:
    """The bearing (n,) rad of each pursuer's sector, in the scene's order, their arrivals (n,) s from now, and the cost."""

    bearings_rad: Array
    arrivals_s: Array
    cost_s: float


def divide(scene: Scene, radius_m: float) -> Division:
    """The best division: for every turn of the circle the optimal assignment, and of these the best, turned least."""
    count = len(scene.pursuers)
    turns = np.arange(0.0, 2.0 * math.pi / count, TURN_STEP_RAD)
    bearings = turns[:, None] + np.arange(count) * (2.0 * math.pi / count)
    times_s = _arrivals_s(scene, radius_m, bearings)
    squares = times_s**2
    seats = np.array([linear_sum_assignment(square)[1] for square in squares])
    arrivals = times_s[np.arange(len(turns))[:, None], np.arange(count), seats]
    best = int(np.argmin(_costs_s(arrivals)))
    return turned(scene, radius_m, bearings[best, seats[best]])


def turned(scene: Scene, radius_m: float, bearings_rad: Array) -> Division:
    """The same pursuers on the same seats, `bearings_rad` (n,), and the whole circle turned as little as all need together."""
    north, east = np.array([(p.north_m - scene.north_m, p.east_m - scene.east_m) for p in scene.pursuers]).T
    away = [wrapped_rad(rest) for rest in (np.arctan2(east, north) - bearings_rad).tolist()]
    bearings = bearings_rad + sum(away) / len(away)
    arrivals = np.diagonal(_arrivals_s(scene, radius_m, bearings[None])[0]).copy()
    return Division(np.array([wrapped_rad(bearing) for bearing in bearings.tolist()]), arrivals, float(_costs_s(arrivals)))


def kept_bearings(scene: Scene, seats: Mapping[str, float]) -> Array | None:
    """Bearings (n,) of the scene's pursuers in `seats`; None where these are not the same vehicles."""
    if set(seats) != {pursuer.name for pursuer in scene.pursuers}:
        return None
    return np.array([seats[pursuer.name] for pursuer in scene.pursuers])


def _arrivals_s(scene: Scene, radius_m: float, bearings_rad: Array) -> Array:
    """(..., n, n) s of every pursuer at every seat of `bearings_rad` (..., n)."""
    starts = np.array([(pursuer.north_m, pursuer.east_m) for pursuer in scene.pursuers])
    speeds = np.array([pursuer.speed_max_m_s for pursuer in scene.pursuers])
    velocity = np.array((scene.v_north_m_s, scene.v_east_m_s))
    places = np.empty((*bearings_rad.shape, 2))
    places[..., 0] = radius_m * np.cos(bearings_rad) + scene.north_m
    places[..., 1] = radius_m * np.sin(bearings_rad) + scene.east_m
    times_s = arrival_times_s(starts, speeds, places, velocity)
    if not len(scene.discs):
        return times_s
    ends = places[..., None, :, :] + times_s[..., None] * velocity
    detours = detours_m(np.broadcast_to(starts[:, None, :], ends.shape), ends, scene.discs, PASSING_M)
    arrivals_s: Array = times_s + detours / speeds[:, None]
    return arrivals_s


def _costs_s(arrivals_s: Array) -> Array:
    """(...,) s of arrivals (..., n)."""
    costs_s: Array = arrivals_s.max(axis=-1) + MEAN_SHARE * (arrivals_s.sum(axis=-1) / arrivals_s.shape[-1])
    return costs_s
