"""A pursuer's intent: as in plain Python, and each of the ways to pursue."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from flightapp.core.types import Array, Limits
from flightapp.planning.ac2f.approach import contact_velocity
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.pursuit import intend, team_distance_m
from flightapp.planning.ac2f.records import INTENT, MEMORY, VIEW, parameter_record
from flightapp.planning.ac2f.stage import COARSE, FINE, TRACKING
from flightapp.planning.plane import Point, Segment
from tests.planning import pursuit_reference as reference

LIMITS = Limits(6.0, 6.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45)
LINE: tuple[Segment, ...] = (((0.0, -200.0), (0.0, 200.0)),)
RING = {"radius_m": 3.0, "hold_radius_m": 2.2}
CONTACT = {"mode": "first"}

coordinate = st.floats(-40.0, 40.0).map(lambda value: round(value, 3) + 0.0)
place = st.tuples(coordinate, coordinate)
speed = st.floats(-5.0, 5.0)
velocity = st.tuples(speed, speed)
disc = st.tuples(coordinate, coordinate, st.floats(0.3, 4.0))
vehicle_limits = st.builds(
    lambda top, acceleration: Limits(top, acceleration, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45),
    st.floats(3.0, 9.0),
    st.floats(2.0, 8.0),
)


def wanted(
    parameters: Ac2fParameters,
    own: Point,
    evader: Point,
    evader_velocity: Point = (0.0, 0.0),
    *,
    team: tuple[Point, ...] = (),
    etas: tuple[float, ...] = (),
    discs: tuple[tuple[float, float, float], ...] = (),
    sides: tuple[Segment, ...] = LINE,
    closed: bool = False,
    lost: bool = False,
    stage: int = COARSE,
    limits: Limits = LIMITS,
) -> tuple[Any, Array]:
    """The intent and the goals of the game; the arrays are longer than needed, as in flight."""
    view, memory, intent = np.zeros(1, VIEW), np.zeros(1, MEMORY), np.zeros(1, INTENT)
    memory["stage"], memory["boundary_lost"] = stage, lost
    view["own_n"], view["own_e"] = own
    view["target_n"], view["target_e"] = evader
    view["target_vn"], view["target_ve"] = evader_velocity
    view["distance_m"] = math.dist(own, evader)
    view["team_count"], view["obstacle_count"] = len(team), len(discs)
    rows = np.full((len(team) + 2, 4), 1e3)
    rows[: len(team), :2] = np.array(team).reshape(-1, 2)
    scene = np.full((len(discs) + 2, 6), 1.0)
    scene[: len(discs), :3] = np.array(discs).reshape(-1, 3)
    count = len(rows) + 1
    goals = np.full((count, 2), math.nan)
    intend(
        parameter_record(parameters, limits),
        memory,
        view,
        rows,
        np.array((*etas, math.nan)),
        scene,
        np.array(sides, dtype=np.float64).reshape(-1, 4),
        closed,
        np.empty((count, 2)),
        np.empty((count, 6)),
        np.empty(count),
        goals,
        intent,
    )
    return intent[0], goals[: len(team) + 1]


def goal_of(intent: Any) -> Point:
    return float(intent["goal_n"]), float(intent["goal_e"])


def velocity_of(intent: Any) -> Point:
    return float(intent["velocity_n"]), float(intent["velocity_e"])


@given(
    own=place,
    team=st.lists(place, max_size=3, unique=True),
    etas=st.lists(st.floats(0.0, 30.0), max_size=3),
    evader=place,
    evader_velocity=velocity,
    discs=st.lists(disc, max_size=6),
    corners=st.lists(place, min_size=2, max_size=4),
    closed=st.booleans(),
    lost=st.booleans(),
    limits=vehicle_limits,
    rule=st.sampled_from([RING, {}]),
)
def test_the_kernel_agrees_with_plain_python(
    own: Point,
    team: list[Point],
    etas: list[float],
    evader: Point,
    evader_velocity: Point,
    discs: list[tuple[float, float, float]],
    corners: list[Point],
    closed: bool,
    lost: bool,
    limits: Limits,
    rule: dict[str, object],
) -> None:
    assume(own not in team and evader not in team)
    parameters = Ac2fParameters.model_validate({"capture": rule})
    sides = tuple(itertools.pairwise([*corners, corners[0]] if closed else corners))
    scene = np.array(discs).reshape(-1, 3)
    python = reference.Pursuit(parameters, limits)
    target = reference.Target(evader, evader_velocity)
    expected = python.intent(own, team, etas, target, scene, sides, closed=closed, boundary_lost=lost)
    found, goals = wanted(
        parameters,
        own,
        evader,
        evader_velocity,
        team=tuple(team),
        etas=tuple(etas),
        discs=tuple(discs),
        sides=sides,
        closed=closed,
        lost=lost,
        limits=limits,
    )
    assert found["contested"] == (expected.game.contested and not lost)
    assert found["boundary_m"] == pytest.approx(expected.game.distance_m, abs=1e-6)
    assert found["eta_s"] == pytest.approx(expected.eta_s, abs=1e-6)
    if math.dist(goals[0], expected.game.goals[0]) < 1e-6:  # where two points are equally good, either may be taken
        assert goal_of(found) == pytest.approx(expected.goal, abs=1e-6)
        assert velocity_of(found) == pytest.approx(expected.velocity, abs=1e-5)


def test_the_evader_past_the_boundary_is_lost_and_is_chased_itself() -> None:
    intent, _ = wanted(Ac2fParameters(), (40.0, 0.0), (-5.0, 0.0), lost=True)
    assert not intent["contested"]
    assert goal_of(intent) == pytest.approx((-5.0 + 0.32, 0.0))


def test_a_standing_evader_is_played_against_at_its_assumed_speed() -> None:
    parameters = Ac2fParameters(evader_speed_assumed_m_s=3.0)
    intent, _ = wanted(parameters, (0.0, 0.0), (60.0, 0.0), (0.0, 0.0))
    assert (intent["point_n"], intent["point_e"]) == pytest.approx((40.0, 0.0))
    assert intent["eta_s"] == pytest.approx((60.0 - 0.32) / LIMITS.speed_max_m_s)


def test_the_literal_game_is_a_choice() -> None:
    where = ((0.0, 0.0), (30.0, 10.0), (-2.0, 0.0))
    team = ((0.0, 25.0),)
    intersection, _ = wanted(Ac2fParameters(), *where, team=team)
    union, _ = wanted(Ac2fParameters(game="union"), *where, team=team)
    assert union["boundary_m"] < intersection["boundary_m"] - 1.0


@pytest.mark.parametrize("stage", [COARSE, FINE, TRACKING])
@pytest.mark.parametrize("goal", ["game", "evader"])
@given(own=place, evader=place, evader_velocity=velocity, team=st.lists(place, max_size=2))
def test_without_lead_the_goal_is_the_game_point_or_where_the_evader_is(
    stage: int, goal: str, own: Point, evader: Point, evader_velocity: Point, team: list[Point]
) -> None:
    parameters = Ac2fParameters.model_validate({"lead": False, "goal": goal, "capture": CONTACT})
    intent, _ = wanted(parameters, own, evader, evader_velocity, team=tuple(team), stage=stage)
    far = stage == COARSE and math.dist(own, evader) >= parameters.fine_trigger_m and goal == "game"
    expected = (float(intent["point_n"]), float(intent["point_e"])) if far else evader
    assert goal_of(intent) == expected
    north, east = velocity_of(intent)
    if math.dist(own, expected) > 0.0:
        assert math.hypot(north, east) == pytest.approx(LIMITS.speed_max_m_s)
        assert north * (expected[1] - own[1]) == pytest.approx(east * (expected[0] - own[0]), abs=1e-6)


def test_without_lead_a_keep_out_is_respected_as_with_it() -> None:
    near = ((10.0, 0.0), (18.0, 1.0), (-3.0, 0.0))
    plain, lead = (wanted(Ac2fParameters.model_validate({"lead": b, "capture": RING}), *near)[0] for b in (False, True))
    assert velocity_of(plain) == velocity_of(lead)
    assert math.dist(goal_of(plain), (18.0, 1.0)) == pytest.approx(2.2)


def test_the_goal_evader_leaves_the_game_out() -> None:
    intent, _ = wanted(Ac2fParameters(goal="evader"), (0.0, 0.0), (40.0, 0.0), (0.0, 3.0))
    meeting_s = float(intent["goal_e"]) / 3.0
    assert math.hypot(*goal_of(intent)) == pytest.approx(meeting_s * LIMITS.speed_max_m_s, abs=0.5)


near = st.tuples(st.floats(-3.1, 3.1), st.floats(0.05, 11.9)).map(lambda at: (at[1] * math.cos(at[0]), at[1] * math.sin(at[0])))
"""A place within the slot range of an evader at the origin."""
slow_velocity = st.tuples(*[st.floats(-3.0, 3.0)] * 2)


def firsts(pursuers: Sequence[Point], evader_velocity: Point, contact: str = "at-once") -> list[Point]:
    """Of `pursuers` of an evader at the origin, those that meet it; all the others flank it."""
    parameters = Ac2fParameters.model_validate({"capture": CONTACT, "contact": contact})
    found = []
    for own in pursuers:
        others = tuple(other for other in pursuers if other != own)
        goal = goal_of(wanted(parameters, own, (0.0, 0.0), evader_velocity, team=others)[0])
        if goal == (0.0, 0.0):
            found.append(own)
        else:
            assert math.hypot(*goal) == pytest.approx(parameters.flank_radius_m)
    return found


@given(pursuers=st.lists(near, min_size=1, max_size=5, unique=True), evader_velocity=slow_velocity, data=st.data())
def test_where_the_first_contact_counts_exactly_one_pursuer_meets_the_evader_whatever_their_order(
    pursuers: list[Point], evader_velocity: Point, data: st.DataObject
) -> None:
    first = firsts(pursuers, evader_velocity)
    assert len(first) == 1
    assert firsts(data.draw(st.permutations(pursuers)), evader_velocity) == first


def test_the_earlier_goes_first_and_of_equals_the_one_further_south_also_where_each_ties_only_with_the_next() -> None:
    assert firsts([(-8.0, 0.0), (5.0, 0.0)], (0.0, 0.0)) == [(5.0, 0.0)]
    assert firsts([(5.0, 0.0), (-5.2, 0.0)], (0.0, 0.0)) == [(-5.2, 0.0)]
    chain = [(5.0, 0.0), (-4.0, 4.12), (-6.6, 0.0)]  # in seconds 0.83, 0.96, 1.10: the last ties with the second, not the first
    assert firsts(chain, (0.0, 0.0)) == [(-4.0, 4.12)]


@pytest.mark.parametrize(
    ("pursuers", "at_once", "encircled"),
    [
        ([(4.0, 0.0), (5.0, 5.0), (5.0, -5.0)], 1, 0),  # all on one side
        ([(4.0, 0.0), (-5.0, 5.0), (-5.0, -5.0)], 1, 1),
        ([(4.0, 0.0), (5.0, 5.0)], 1, 1),  # two enclose nothing, however long one waits
    ],
)
def test_where_it_is_to_be_encircled_nobody_meets_the_evader_before(pursuers: list[Point], at_once: int, encircled: int) -> None:
    assert len(firsts(pursuers, (0.0, 0.0))) == at_once
    assert len(firsts(pursuers, (0.0, 0.0), "encircled")) == encircled


@given(
    gap=near,
    evader_velocity=st.tuples(*[st.floats(-9.0, 9.0)] * 2),
    closing_m_s=st.floats(0.0, 3.0),
    limits=vehicle_limits,
)
def test_the_way_to_the_contact_closes_within_the_speed_limit_and_slows_down_to_the_evader(
    gap: Point, evader_velocity: Point, closing_m_s: float, limits: Limits
) -> None:
    parameters = Ac2fParameters(contact_closing_m_s=closing_m_s)
    record, distance = parameter_record(parameters, limits), math.hypot(*gap)
    velocity = contact_velocity(record, *gap, *evader_velocity)
    assert math.hypot(*velocity) <= limits.speed_max_m_s + 1e-9
    closing = ((velocity[0] - evader_velocity[0]) * gap[0] + (velocity[1] - evader_velocity[1]) * gap[1]) / distance
    evader_speed = math.hypot(*evader_velocity)
    braking = parameters.contact_braking_share * limits.acceleration_max_m_s2
    wanted_m_s = math.sqrt(closing_m_s**2 + 2.0 * braking * distance)
    if evader_speed < limits.speed_max_m_s - 1e-3:
        assert 0.0 < closing <= wanted_m_s + 1e-9
        assert closing >= min(wanted_m_s, limits.speed_max_m_s - evader_speed) - 1e-9
        off_course = (velocity[0] - evader_velocity[0]) * gap[1] - (velocity[1] - evader_velocity[1]) * gap[0]
        assert off_course == pytest.approx(0.0, abs=1e-9 * (1.0 + distance))  # a straight course to the intercept


def test_where_the_evader_is_reached_its_velocity_is_flown() -> None:
    record = parameter_record(Ac2fParameters(), LIMITS)
    assert contact_velocity(record, 0.0, 0.0, 2.0, -1.0) == (2.0, -1.0)


def test_an_early_pursuer_slows_down_to_arrive_within_the_window_of_the_last() -> None:
    where = ((20.0, 0.0), (60.0, 0.0), (-2.0, 0.0))
    team = ((20.0, 10.0),)
    alone, _ = wanted(Ac2fParameters(), *where, team=team)
    eta_s = float(alone["eta_s"])
    assert math.hypot(*velocity_of(alone)) == pytest.approx(LIMITS.speed_max_m_s)

    def speed_with(late_s: float, **changes: object) -> float:
        parameters = Ac2fParameters.model_validate({"arrival_margin_m": 8.0, **changes})
        return math.hypot(*velocity_of(wanted(parameters, *where, team=team, etas=(eta_s + late_s,))[0]))

    assert speed_with(0.9) == pytest.approx(LIMITS.speed_max_m_s), "within the window nobody slows down"
    slowed = speed_with(3.0)
    assert eta_s * LIMITS.speed_max_m_s / slowed == pytest.approx(eta_s + 3.0 - 1.0)
    assert speed_with(300.0) == pytest.approx(0.6 * LIMITS.speed_max_m_s)
    assert speed_with(3.0, arrival_margin_m=1e3) == pytest.approx(LIMITS.speed_max_m_s), "near the boundary nobody waits"


def test_an_uncontested_pursuer_does_not_wait_for_the_others() -> None:
    intent, _ = wanted(Ac2fParameters(arrival_margin_m=0.0), (40.0, 0.0), (8.0, 0.0), etas=(60.0,))
    assert not intent["contested"]
    assert math.hypot(*velocity_of(intent)) == pytest.approx(LIMITS.speed_max_m_s)


@pytest.mark.parametrize("hold_radius_m", [0.4, 2.2])
def test_teammates_may_come_as_near_as_neighbouring_slots_demand(hold_radius_m: float) -> None:
    capture = {"radius_m": 3.0, "hold_radius_m": hold_radius_m}
    parameters = Ac2fParameters.model_validate({"capture": capture})
    for count in range(1, 7):
        distance_m = team_distance_m(parameter_record(parameters, LIMITS), count)
        assert distance_m == pytest.approx(reference.Pursuit(parameters, LIMITS).team_distance_m(count))
