"""Encounters flown to their end: nobody comes too close, and everybody arrives before a deadline in simulated time."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import clearance_m
from flightapp.core.types import Array, Setpoint, TeamMember
from flightapp.safety.api import SafetyContext
from flightapp.safety.escape import Rule
from flightapp.safety.guards.geofence import GeofenceGuard
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.safety.guards.separation import SeparationGuard
from flightapp.safety.velocity_bounds import Planar
from tests.safety.closed_loop import LIMITS, PARAMETERS, PERIOD_S, Body, context_of, discs_at, supervisor_of, towards

SQUARE = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
ARRIVED_M = 0.3
Place = tuple[float, float]


class Stubborn(SeparationGuard):
    """The unsafe twin of the fixed order: keeps the distance, but nobody ever yields."""

    def escape(self, wish: Planar, rules: list[Rule], context: SafetyContext) -> Planar | None:  # type: ignore[override]
        return None


@dataclass
class Encounter:
    """Who starts where and wants to go where, at which speed; the frozen ones neither move nor hear."""

    starts: dict[str, Place]
    goals: dict[str, Place]
    speeds: dict[str, float] | None = None
    discs: Array | None = None
    fence: tuple[Place, ...] | None = None
    frozen: tuple[str, ...] = ()

    def fly(self, seconds: float, guard: type[SeparationGuard] | None = SeparationGuard) -> Ending:
        """To the arrival of all or the deadline; states of the others are one control period old."""
        bodies = {name: Body(name, start) for name, start in self.starts.items()}
        around = [GeofenceGuard(self.fence, PARAMETERS)] if self.fence else []
        around += [] if self.discs is None else [ObstacleStopGuard(PARAMETERS)]
        supervisors = {
            name: supervisor_of(*around, separation=None if guard is None else guard(PARAMETERS)) for name in self.starts
        }
        heard = {name: body.state(0.0) for name, body in bodies.items()}
        least, clearance, missing = math.inf, math.inf, set(self.starts) - set(self.frozen)
        for step in range(round(seconds / PERIOD_S)):
            t_s, sent = step * PERIOD_S, {}
            for name, body in bodies.items():
                team = tuple(TeamMember(o, heard[o], "", None, PERIOD_S) for o in bodies if o != name)
                speed = (self.speeds or {}).get(name, 5.0)
                wish = np.zeros(3) if name in self.frozen else towards(self.goals[name], speed)(t_s, body)
                context = context_of(body, t_s, team=team, discs=self.discs)
                sent[name] = supervisors[name].check(Setpoint(wish, 0.0), context).setpoint
            heard = {name: body.state(t_s) for name, body in bodies.items()}
            for name, body in bodies.items():
                if name not in self.frozen:
                    body.fly(sent[name])
                if math.dist(body.position[:2], self.goals.get(name, (math.inf, 0.0))) < ARRIVED_M:
                    missing.discard(name)
                if self.discs is not None:
                    clearance = min(clearance, clearance_m(body.position[:2], self.discs, LIMITS.body_radius_m))
            for one, other in itertools.combinations(bodies.values(), 2):
                least = min(least, math.dist(one.position[:2], other.position[:2]))
            if not missing:
                break
        return Ending(least, clearance, tuple(sorted(missing)))


@dataclass
class Ending:
    least_m: float
    clearance_m: float
    missing: tuple[str, ...]


def _spokes(count: int, turned: float = 0.3) -> Encounter:
    places = [(8 * math.cos(a), 8 * math.sin(a)) for a in turned + np.linspace(0, 2 * math.pi, count + 1)[:-1]]
    names = [f"p{index}" for index in range(count)]
    return Encounter(dict(zip(names, places, strict=True)), {n: (-p[0], -p[1]) for n, p in zip(names, places, strict=True)})


def _corridor(half_m: float, length_m: float = 5.0) -> Array:
    return discs_at(*[(n, e, 0.5) for n in np.arange(-length_m, length_m + 0.1, 0.35) for e in (-half_m - 0.5, half_m + 0.5)])


def _pair(first: Place, second: Place, to_first: Place, to_second: Place, **more: object) -> Encounter:
    return Encounter({"p1": first, "p2": second}, {"p1": to_first, "p2": to_second}, **more)  # type: ignore[arg-type]


OPEN = {
    "head-on": _pair((-8, 0), (8, 0), (8, 0), (-8, 0)),
    "crossing": _pair((-8, 0), (0, -8), (8, 0), (0, 8)),
    "crossing, lower from the right": _pair((0, -8), (-8, 0), (0, 8), (8, 0)),
    "overtaking": _pair((-4, 0), (-8, 0), (5, 0), (12, 0), speeds={"p1": 1.5}),
    "overtaking, lower behind": _pair((-8, 0), (-4, 0), (12, 0), (5, 0), speeds={"p2": 1.5}),
    "three in a point": _spokes(3),
    "a frozen one in the way": _pair((-8, 0), (0, 0), (8, 0), (0, 0), frozen=("p2",)),
    "a frozen lower one in the way": _pair((0, 0), (-8, 0.1), (0, 0), (8, 0), frozen=("p1",)),
    "head-on along the fence": _pair((-8, 9), (8, 9), (8, 9), (-8, 9), fence=SQUARE),
    "head-on along the other fence": _pair((8, -9), (-8, -9), (-8, -9), (8, -9), fence=SQUARE),
}


@pytest.mark.parametrize("name", OPEN)
def test_every_encounter_ends_well_and_its_twin_comes_too_close(name: str) -> None:
    ending = OPEN[name].fly(15)
    assert ending.least_m >= PARAMETERS.separation_min_m
    assert ending.missing == ()
    assert OPEN[name].fly(15, guard=None).least_m < PARAMETERS.separation_min_m


TIGHT = {
    "corridor": _pair((-9, 0.1), (9, 0.3), (9, 0), (-9, 0), discs=_corridor(1.0)),
    "corridor, exactly opposite": _pair((-9, 0), (9, 0), (9, 0), (-9, 0), discs=_corridor(1.2)),
    "one stands on the place beside the fence": _pair((9, 9), (0, 9), (0, 9), (9, 9), fence=SQUARE),
}


@pytest.mark.parametrize("name", TIGHT)
def test_where_there_is_no_room_the_lower_yields_and_without_the_order_nobody_passes(name: str) -> None:
    ending = TIGHT[name].fly(45)
    assert ending.least_m >= PARAMETERS.separation_min_m
    assert ending.clearance_m > 0.0
    assert ending.missing == ()
    assert TIGHT[name].fly(25, guard=Stubborn).missing != ()


place = st.tuples(st.floats(-7, 7), st.floats(-7, 7))


@settings(max_examples=15, deadline=None)
@given(st.lists(place, min_size=2, max_size=3), st.lists(place, min_size=3, max_size=3), st.booleans())
def test_any_encounter_keeps_the_distance_and_two_always_end_it(
    starts: list[Place], goals: list[Place], one_does_nothing: bool
) -> None:
    """Three at close quarters keep the distance too; an arrived one may stand on another's last metres beyond the deadline."""
    for places in (starts, goals[: len(starts)]):
        assume(all(math.dist(one, other) > 2.3 for one, other in itertools.combinations(places, 2)))
    frozen = ("p0",) if one_does_nothing else ()
    assume(not frozen or all(math.dist(starts[0], goal) > 2.3 for goal in goals))
    named = {f"p{index}": where for index, where in enumerate(starts)}
    encounter = Encounter(named, {name: goals[index] for index, name in enumerate(named)}, frozen=frozen)
    ending = encounter.fly(40 if len(starts) == 2 else 15)
    assert ending.least_m >= PARAMETERS.separation_min_m
    assert ending.missing == () or len(starts) > 2


@settings(max_examples=10, deadline=None)
@given(st.floats(0.0, 3.0), st.integers(0, 50))
def test_stale_news_widen_the_distance_and_keep_it(age_s: float, seed: int) -> None:
    """The other drifts at 0.6 m/s along a course that was last told `age_s` ago."""
    heading = np.random.default_rng(seed).uniform(-math.pi, math.pi)
    drift = 0.6 * np.array([math.cos(heading), math.sin(heading), 0.0])
    body, other = Body("p1", (-7.0, 0.0)), Body("p2", (0.0, 0.0), drift)
    supervisor, least = supervisor_of(separation=SeparationGuard(PARAMETERS)), math.inf
    for step in range(120):
        t_s = step * PERIOD_S
        told = Body("p2", (other.position - drift * min(age_s, t_s))[:2], drift)
        member = TeamMember("p2", told.state(t_s), "", None, min(age_s, t_s))
        wish = Setpoint(towards(other.position[:2])(t_s, body), 0.0)
        body.fly(supervisor.check(wish, context_of(body, t_s, team=(member,))).setpoint)
        other.position = other.position + drift * PERIOD_S
        least = min(least, math.dist(body.position[:2], other.position[:2]))
    assert least >= PARAMETERS.separation_min_m
