"""One hunter among what can go wrong: section 4 of the specification, and that the same flight decides the same."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import (
    Assignment,
    Boundary,
    Decision,
    Limits,
    Observation,
    ObstacleSet,
    Rendezvous,
    TargetTrack,
    TeamMember,
    VehicleState,
)
from flightapp.planning import make_planner
from flightapp.planning.api import Planner
from flightapp.planning.hunting.hunt import Hunter, Rules, plan_hunt
from flightapp.planning.polygon import Bodies
from flightapp.planning.prediction import fit_track

LIMITS = Limits(6.0, 6.0, 60.0, 3.0, 12.0, 2.0, 0.25, 0.25)
LINE = Boundary(np.array([[-50.0, -50.0], [-50.0, 50.0]]), closed=False)
FACTS = {"reaction_s": 0.1, "response_lag_s": 0.0, "command_blend": 1.0, "vehicle_radius_max_m": 0.0}
RING = {"capture": {"mode": "all", "radius_m": 4.0, "hold_radius_m": 3.0}}
Place = tuple[float, float]


def state(place: Place, velocity: Place = (0.0, 0.0), t_s: float = 0.0) -> VehicleState:
    return VehicleState(t_s, np.array((*place, -5.0)), np.array((*velocity, 0.0)), 0.0)


def seen(
    own: Place,
    target: Place | None,
    mates: tuple[Place, ...] = (),
    *,
    t_s: float = 0.0,
    target_m_s: Place = (0.0, 0.0),
    discs: tuple[tuple[float, float, float], ...] = (),
    age_s: float = 0.0,
    assignment: Assignment | None = None,
) -> Observation:
    team = tuple(TeamMember(f"p{k + 2}", state(mate, t_s=t_s), "approach", None, 0.0) for k, mate in enumerate(mates))
    track = None
    if target is not None:
        track = TargetTrack(t_s, np.array((*target, -5.0)), np.array((*target_m_s, 0.0)), np.eye(6), age_s)
    rows = np.array([(n, e, r, 0.0, 0.0, -np.inf, np.inf) for n, e, r in discs]).reshape(-1, 7)
    return Observation(t_s, 0.1, state(own, t_s=t_s), team, track, ObstacleSet(t_s, rows, np.zeros((0, 2))), LINE, assignment)


def hunter(name: str = "hunting", **given: object) -> Planner:
    return make_planner(name, limits=LIMITS, parameters={**FACTS, **RING, **given}, seed=5)


def is_sound(decision: Decision) -> bool:
    numbers = (*decision.velocity_ned_m_s.tolist(), decision.yaw_rad)
    return all(map(math.isfinite, numbers)) and math.hypot(*numbers[:2]) <= LIMITS.speed_max_m_s + 1e-9


@pytest.mark.parametrize("name", ["hunting", "tracking-hunting", "dwa"])
@pytest.mark.parametrize(
    ("own", "target", "mates"),
    [
        ((0.0, 0.0), (0.0, 0.0), ((3.0, 0.0), (0.0, 3.0))),  # the target on top
        ((0.0, 0.0), (30.0, 0.0), ((10.0, 0.0), (20.0, 0.0))),  # collinear
        ((0.0, 0.0), (30.0, 0.0), ()),  # alone: it trails
        ((0.0, 0.0), (30.0, 0.0), ((0.0, 9.0),)),  # two: ahead and behind
        ((0.0, 0.0), (30.0, 0.0), ((0.0, 0.0), (0.0, 0.0))),  # all in one place
        ((0.0, 0.0), None, ((5.0, 0.0),)),  # no target
    ],
)
def test_degenerate_teams_and_targets_are_flown_without_a_number_that_is_none(
    name: str, own: Place, target: Place | None, mates: tuple[Place, ...]
) -> None:
    planner = hunter(name)
    for tick in range(5):
        assert is_sound(planner.step(seen(own, target, mates, t_s=0.1 * tick)))


def test_a_target_that_is_lost_is_first_looked_for_where_it_was_and_then_around() -> None:
    planner = hunter()
    planner.step(seen((0.0, 0.0), (30.0, 0.0)))
    stale = planner.step(seen((0.0, 0.0), None, t_s=3.0))
    assert stale.mode == "search"
    assert stale.goal_ned_m is not None
    assert stale.goal_ned_m[:2].tolist() == [30.0, 0.0]
    lost = planner.step(seen((0.0, 0.0), None, t_s=15.0))
    assert lost.mode == "search"
    assert lost.goal_ned_m is not None
    assert lost.goal_ned_m[0] < -10.0


def test_inside_an_obstacle_it_leaves_outwards_slowly_before_anything_else() -> None:
    decision = hunter().step(seen((0.5, 0.0), (-30.0, 0.0), discs=((0.0, 0.0, 1.0),)))
    assert decision.velocity_ned_m_s[0] == pytest.approx(0.3 * 6.0)


def test_the_leaders_plan_is_obeyed_and_without_one_the_same_is_planned_alone() -> None:
    there = Rendezvous(20.0, 40.0, math.pi, 3.0, 3, 1, closing=False)
    told = hunter().step(
        seen(
            (0.0, 0.0),
            (80.0, 40.0),
            ((0.0, 9.0), (0.0, 30.0)),
            target_m_s=(-2.0, 0.0),
            assignment=Assignment(0.5 * math.pi, 9.0, there),
        )
    )
    assert told.diagnostics["plan"] == "leader"
    assert told.goal_ned_m is not None
    assert told.goal_ned_m[:2].tolist() == pytest.approx([20.0, 43.0])
    alone = hunter().step(seen((0.0, 0.0), (80.0, 40.0), ((0.0, 9.0), (0.0, 30.0))))
    assert alone.diagnostics["plan"] == "alone"


def test_the_same_observations_give_the_same_decisions_bit_for_bit() -> None:
    wall = tuple((6.0, float(e), 0.8) for e in range(-6, 7))
    first, second = hunter(), hunter()
    for tick in range(30):
        look = seen((4.0, 0.0), (20.0, 0.0), ((0.0, 9.0),), t_s=0.1 * tick, discs=wall)
        a, b = first.step(look), second.step(look)
        assert a.velocity_ned_m_s.tobytes() == b.velocity_ned_m_s.tobytes()
        assert a.diagnostics == b.diagnostics


def test_in_front_of_a_trap_it_is_guided_around_it() -> None:
    planner = hunter()
    wall = tuple((6.0, float(e), 0.8) for e in range(-8, 9)) + tuple((float(n), e, 0.8) for n in range(1, 6) for e in (-8.0, 8.0))
    looks = [planner.step(seen((4.0, 0.0), (20.0, 0.0), t_s=0.1 * tick, discs=wall)) for tick in range(20)]
    guided = [look for look in looks if look.diagnostics["guidance"]]
    assert guided
    assert guided[-1].diagnostics["guidance"] == "guided out of a trap"


def test_a_value_that_cannot_be_is_refused_in_one_sentence() -> None:
    for given, word in (
        ({"separation_m": 0.0}, "separation_m"),
        ({"speed_samples": 1}, "speed_samples"),
        ({"no_such": 1}, "no_such"),
    ):
        with pytest.raises(InputError, match=word) as refused:
            hunter(**given)
        assert "\n" not in str(refused.value)
    with pytest.raises(InputError, match="window"):
        hunter("dwa", window="horizon")
    with pytest.raises(ValueError, match="separation_m"):
        Bodies(1.0, 1.0, 0.0)
    for field in ("speed_max_m_s", "acceleration_max_m_s2", "yaw_acceleration_max_rad_s2"):
        for value in (0.0, -1.0, math.nan):
            with pytest.raises(InputError, match=f"limits.{field} = .*must be a finite number greater than 0"):
                make_planner("hunting", limits=replace(LIMITS, **{field: value}), parameters=FACTS)


RULES = Rules(Bodies(2.0, 2.0, 5.0), 16.0, 0.5, 1.0472, 0.5, 2.0578, 600.0, 3.0, 5.0)
TABLE_1 = ((250.0, 50.0, 1.6708), (90.0, 110.0, 0.8708), (50.0, 250.0, 0.0708), (110.0, 410.0, -0.8292), (290.0, 450.0, 4.3708))


@pytest.mark.parametrize(
    ("speed", "base", "time_s", "way_m"), [(1.0289, (299.0, 328.0), 149.0, 1128.0), (2.0578, (253.0, 267.0), 113.0, 980.0)]
)
def test_the_papers_free_runs_are_planned_where_the_specification_says(
    speed: float, base: Place, time_s: float, way_m: float
) -> None:
    """Tables 1 and 3: base point, meeting time and the sum of the straight ways at r_h = 15 m, here at 16 m."""

    course = 0.5 * math.pi + 2.5
    times = np.arange(-10.0, 0.1, 0.5)
    places = np.array([390.0, 450.0]) + speed * times[:, None] * np.array([math.cos(course), math.sin(course)])
    team = tuple(Hunter(f"p{k}", (n, e), heading, 0.0, 2.0578) for k, (n, e, heading) in enumerate(TABLE_1))
    hunt = plan_hunt(0.0, (390.0, 450.0), course, fit_track(times, places, 0.0), team, np.zeros((0, 3)), RULES, None)
    assert math.dist(hunt.base_m, base) < 5.0
    assert hunt.meeting_s == pytest.approx(time_s, abs=2.0)
    ways = sum(math.dist(one.place_m, hunt.places[one.name].place_m) for one in team)
    assert ways == pytest.approx(way_m, rel=0.02)
    assert sorted(place.slot for place in hunt.places.values()) == [0, 1, 2, 3, 4]


def test_who_cannot_be_in_time_trails_behind_the_others() -> None:
    team = tuple(
        Hunter(f"p{k}", place, 0.0, 0.0, 2.0) for k, place in enumerate(((90.0, 0.0), (90.0, 9.0), (90.0, -9.0), (-400.0, 0.0)))
    )

    times = np.arange(-10.0, 0.1, 0.5)
    fit = fit_track(times, np.stack((2.0 * times, np.zeros_like(times)), axis=1), 0.0)
    hunt = plan_hunt(0.0, (0.0, 0.0), 0.0, fit, team, np.zeros((0, 3)), RULES, None)
    assert hunt.slots == 3
    assert hunt.places["p3"].slot == -1
    assert all(hunt.places[name].slot >= 0 for name in ("p0", "p1", "p2"))
