"""The gains of the two methods whose sources search them, found on random scenes that are not among those reported."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.adaptive_apf.gains import Gains
from flightapp.sim.field_study.flight import FieldFlight, fly_scene
from flightapp.sim.field_study.methods import MOVING_GAINS, Method, gains_of, inertia_of
from flightapp.sim.field_study.scenes import moving_obstacles
from flightapp.sim.field_study.search import Found, grey_wolves, random_search

FIRST_SEED = 10_000
SEARCH_SEED = 7
TURN_COST_M, FAILED_COST_M, CLEARANCE_COST = 5.0, 100.0, 10.0


@dataclass(frozen=True, slots=True)
class SearchSize:
    """How much is searched; the defaults are the specification's."""

    scenes: int = 20
    draws: int = 200
    wolves: int = 20
    rounds: int = 30

    def flights(self, method: Method) -> int:
        """That the search for `method` takes."""
        return self.scenes * {"": 0, "draws": self.draws, "wolves": self.wolves * self.rounds}[method.search]


def cost_of(flight: FieldFlight, gains: Gains) -> float:
    """Length, in m, and what sharp turns, failure and passing nearer than the margin cost beside."""
    near_m = max(0.0, gains.margin_m - flight.clearance_m)
    failed = 0.0 if flight.arrived else FAILED_COST_M
    return flight.length_m + TURN_COST_M * flight.turn_max_rad + failed + CLEARANCE_COST * near_m


def searched_gains(
    method: Method, step_m: float, steps: int, size: SearchSize, advance: Callable[[int], None], *, literal: bool = False
) -> tuple[dict[str, float], Found | None]:
    """By the name of what is searched, and the search; nothing for a method that searches nothing."""
    if not method.search:
        return {}, None
    scenes = [moving_obstacles(seed) for seed in range(FIRST_SEED, FIRST_SEED + size.scenes)]

    def cost(place: Array) -> float:
        values = _named(method, place)
        gains = gains_of(method, step_m, MOVING_GAINS, literal=literal, searched=values)
        inertia = inertia_of(method, values)
        flights = [fly_scene(scene, method, gains, step_m, steps, seed, inertia) for seed, scene in enumerate(scenes)]
        advance(len(flights))
        return math.fsum(cost_of(flight, gains) for flight in flights) / len(flights)

    low, high = np.array(list(method.ranges.values())).T
    if method.search == "draws":
        found = random_search(cost, low, high, size.draws, SEARCH_SEED)
    else:
        found = grey_wolves(cost, low, high, size.wolves, size.rounds, SEARCH_SEED)
    return _named(method, found.place), found


def _named(method: Method, place: Array) -> dict[str, float]:
    return dict(zip(method.ranges, place.tolist(), strict=True))
