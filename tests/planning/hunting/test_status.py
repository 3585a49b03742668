"""What is not as the hunt wants it is told: too few, too late, too few heard, a slot where none can be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Assignment, Rendezvous
from flightapp.planning.hunting.guide import outside_m
from flightapp.planning.hunting.hunt import Hunter, Rules, plan_hunt, trailing_hunt
from flightapp.planning.hunting.planner import HuntingPlanner
from flightapp.planning.polygon import Bodies, places_on_ring_m, slot_bearings_rad
from flightapp.planning.prediction import fit_track
from tests.planning.hunting.test_planner import Place, hunter, seen

FOUR = ((0.0, 9.0), (0.0, 18.0), (0.0, -9.0), (0.0, -18.0))
LED = Assignment(0.0, 9.0, Rendezvous(30.0, 0.0, math.pi, 3.0, 5, 1, closing=False))
RULES = Rules(Bodies(2.0, 2.0, 5.0), 16.0, 0.5, 1.0472, 0.5, 2.0578, 600.0, 3.0, 5.0)


def flags(mates: tuple[Place, ...], assignment: Assignment | None = None) -> list[str]:
    told = hunter().step(seen((0.0, 0.0), (40.0, 0.0), mates, assignment=assignment)).diagnostics["flags"]
    assert isinstance(told, list)
    return told


@pytest.mark.parametrize(("count", "is_degraded"), [(1, True), (2, True), (3, False), (5, False)])
def test_fewer_than_three_are_degraded_and_never_claim_a_capture(count: int, is_degraded: bool) -> None:
    assert ("degraded" in flags(FOUR[: count - 1])) is is_degraded


def test_one_trails_and_two_are_ahead_and_behind_and_neither_is_the_formation() -> None:
    alone = hunter(capture={"mode": "formation", "radius_m": 4.0, "hold_radius_m": 3.0})
    for tick in range(40):
        decision = alone.step(seen((37.0, 0.0), (40.0, 0.0), t_s=0.1 * tick, target_m_s=(1.0, 0.0)))
    assert decision.goal_ned_m is not None
    assert decision.goal_ned_m[:2].tolist() == pytest.approx([37.0, 0.0], abs=0.1)
    assert decision.diagnostics["captured"] is False
    trio = hunter(capture={"mode": "formation", "radius_m": 4.0, "hold_radius_m": 3.0})
    for tick in range(10):
        told = trio.step(seen((37.0, 0.0), (40.0, 0.0), ((41.5, 2.6), (41.5, -2.6)), t_s=0.1 * tick))
    assert told.diagnostics["captured"] is True
    pair = hunter().step(seen((10.0, 0.0), (40.0, 0.0), ((70.0, 0.0),)))
    assert pair.diagnostics["base_point"] == pytest.approx([40.0, 0.0], abs=1.0)
    assert pair.goal_ned_m is not None
    assert pair.goal_ned_m[:2].tolist() == pytest.approx([37.0, 0.0], abs=1.0)


def test_where_the_first_contact_ends_the_hunt_nobody_is_degraded() -> None:
    told = hunter(capture={"mode": "first", "radius_m": 1.0}).step(seen((0.0, 0.0), (40.0, 0.0)))
    assert told.diagnostics["flags"] == []


def test_a_faster_target_from_astern_is_unreachable_and_cut_off_ahead_of_where_it_is() -> None:
    """Twice as fast, the team abeam and behind: outside of the cone of asin(0.5) about its course."""
    team = tuple(Hunter(f"p{k}", (-20.0, 60.0 + 10.0 * k), -0.5 * math.pi, 1.0, 1.0) for k in range(3))
    times = np.arange(-10.0, 0.1, 0.5)
    fit = fit_track(times, np.stack((2.0 * times, np.zeros_like(times)), axis=1), 0.0)
    hunt = plan_hunt(0.0, (0.0, 0.0), 0.0, fit, team, np.zeros((0, 3)), RULES, None)
    assert not hunt.reachable
    assert hunt.base_m[0] > 10.0, "on its course, not where it is"
    late = Assignment(0.0, 9.0, Rendezvous(30.0, 0.0, math.pi, 3.0, 3, 1, closing=False, reachable=False))
    assert flags(FOUR[:2], late) == ["unreachable"]


def flown_without_a_leader(heard: int) -> tuple[HuntingPlanner, list[str], list[str]]:
    """Five that were led; then nobody leads and only `heard` mates are heard: its flags, and all that was told."""
    planner = hunter()
    assert isinstance(planner, HuntingPlanner)
    reasons = []
    for tick in range(60):
        t_s = 0.1 * tick
        mates, led = (FOUR, LED) if tick < 10 else (FOUR[:heard], None)
        decision = planner.step(seen((0.0, 0.0), (40.0, 0.0), mates, t_s=t_s, target_m_s=(-1.0, 0.0), assignment=led))
        reasons.append(decision.reason)
    found = decision.diagnostics["flags"]
    assert isinstance(found, list)
    return planner, found, [reason for reason in reasons if reason]


@pytest.mark.parametrize(("heard", "lacks"), [(0, True), (1, True), (2, False), (4, False)])
def test_without_a_leader_and_without_a_majority_it_says_so_once_and_trails(heard: int, lacks: bool) -> None:
    planner, found, reasons = flown_without_a_leader(heard)
    assert ("no quorum" in found) is lacks
    assert sum("no quorum" in reason for reason in reasons) == int(lacks)
    decision = planner.step(seen((0.0, 0.0), (40.0, 0.0), FOUR[:heard], t_s=6.0, target_m_s=(-1.0, 0.0)))
    assert decision.diagnostics["plan"] == "alone"
    slot = decision.diagnostics["slot"]
    assert isinstance(slot, int)
    assert (slot < 0) is lacks
    if lacks:
        assert decision.goal_ned_m is not None
        assert decision.goal_ned_m[0] > 40.0, "behind a target that comes south"


def test_a_team_that_nobody_ever_led_misses_no_quorum() -> None:
    planner = hunter()
    for tick in range(30):
        mates = FOUR if tick < 10 else ()
        told = planner.step(seen((0.0, 0.0), (40.0, 0.0), mates, t_s=0.1 * tick))
    assert told.diagnostics["flags"] == ["degraded"]


def test_who_trails_keeps_a_ring_of_any_number_and_the_others_at_a_distance() -> None:
    team = tuple(Hunter(f"p{k}", (-60.0 - 20.0 * k, 5.0), 0.0, 0.0, 2.0) for k in range(2))
    hunt = trailing_hunt(0.0, (0.0, 0.0), 0.3, team, RULES)
    assert [hunt.places[name].slot for name in ("p0", "p1")] == [-1, -2]
    apart = RULES.bodies.separation_m + 2.0 * RULES.bodies.pursuer_radius_m
    trailing = [place.place_m for place in hunt.places.values()]
    assert math.dist(*trailing) >= apart
    for count in range(3, 6):
        ring = places_on_ring_m(np.zeros(2), hunt.radius_m, slot_bearings_rad(count, 0.3))
        assert min(math.dist(slot, place) for slot in ring for place in trailing) >= apart


def test_news_of_what_comes_and_goes_waits_until_it_lasts() -> None:
    led = hunter()
    reasons = []
    for tick in range(60):
        late = 20 <= tick < 25 or tick >= 40  # half a second is no news
        there = Rendezvous(30.0, 0.0, math.pi, 3.0, 5, 1, closing=False, reachable=not late)
        look = seen((0.0, 0.0), (40.0, 0.0), FOUR, t_s=0.1 * tick, assignment=Assignment(0.0, 9.0, there))
        reasons.append(led.step(look).reason)
    told = [tick for tick, reason in enumerate(reasons) if "unreachable" in reason]
    assert told == [50]


def test_a_slot_inside_an_obstacle_is_told_and_the_nearest_free_place_is_the_goal() -> None:
    there = Rendezvous(30.0, 0.0, math.pi, 3.0, 5, 1, closing=False)
    look = seen((0.0, 0.0), (40.0, 0.0), FOUR, discs=((27.0, 0.0, 1.0),), assignment=Assignment(math.pi, 9.0, there))
    assert hunter().step(look).diagnostics["flags"] == ["goal inside an obstacle"]


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.floats(-4, 4), st.floats(-4, 4), st.floats(0.5, 3.0)), max_size=5))
def test_the_nearest_free_place_is_free_also_among_obstacles_that_overlap(discs: list[tuple[float, float, float]]) -> None:
    rows = np.array(discs).reshape(-1, 3)
    n, e = outside_m((0.0, 0.0), rows)
    assert all(math.hypot(n - a, e - b) >= r - 1e-9 for a, b, r in discs)
