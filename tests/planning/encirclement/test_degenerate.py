"""What goes wrong (section 4 of the specification), row by row: a finite velocity within the limit, and a flag that says so."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.core.types import Assignment, Decision, Observation
from flightapp.planning.registry import ENCIRCLEMENT
from tests.planning.encirclement.arena import CAPTURE, LIMITS, chase, member, observation, pursuer

EVADER = (5.0, 0.0)
OTHERS = [(0.0, 5.0), (0.0, -5.0)]


def step(seen: Observation, **parameters: object) -> Decision:
    decision = pursuer(**parameters).step(seen)  # type: ignore[arg-type]
    assert np.isfinite(decision.velocity_ned_m_s).all()
    assert np.hypot(*decision.velocity_ned_m_s[:2]) <= 1.0 + 1e-9
    return decision


def flags(decision: Decision) -> list[str]:
    return list(decision.diagnostics["flags"])  # type: ignore[call-overload]


def test_within_the_capture_radius_at_the_start_it_is_done() -> None:
    decision = step(observation((4.2, 0.0), OTHERS, EVADER))
    assert decision.mode == "done"
    assert decision.diagnostics["captured"]


def test_on_the_evader_it_is_done_and_finite() -> None:
    assert step(observation(EVADER, OTHERS, EVADER)).mode == "done"


def test_two_in_one_place_leave_in_different_directions() -> None:
    a = step(observation((0.0, 0.0), [member("p2", 0.0, (0.0, 0.0)), *OTHERS], EVADER))
    b = step(observation((0.0, 0.0), [member("p1", 0.0, (0.0, 0.0)), *OTHERS], EVADER))
    assert "violation" in flags(a)
    assert "violation" in flags(b)
    apart = 0.1 * np.hypot(*(a.velocity_ned_m_s - b.velocity_ned_m_s)[:2])
    assert apart > 0.01


def test_too_near_to_a_teammate_both_leave_each_other() -> None:
    found = chase([(0.0, 0.0), (0.2, 0.0), (0.0, 6.0)], (5.0, 0.0), seconds=0.4)
    first = found.decisions[0]
    assert "violation" in flags(first[0])
    assert first[0].velocity_ned_m_s[0] < 0.0 < first[1].velocity_ned_m_s[0]
    assert np.linalg.norm(found.places[2][0] - found.places[2][1]) >= 0.3 - 1e-9


def test_where_no_place_is_safe_it_leaves_what_is_worst() -> None:
    squeezed = [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.05)]
    decision = step(observation((0.0, 0.0), squeezed, EVADER))
    assert "no safe place" in flags(decision)
    assert decision.velocity_ned_m_s[1] > 0.0, "away from the nearest"


@pytest.mark.parametrize("place", [(0.3, 0.0), (0.9, 0.0), (1.05, 0.0)])
def test_in_an_obstacle_or_its_buffer_it_leaves_by_the_nearest_way(place: tuple[float, float]) -> None:
    decision = step(observation(place, OTHERS, (-5.0, 0.0), [(0.0, 0.0, 1.0)]))
    assert decision.velocity_ned_m_s[0] > 0.0
    assert "violation" in flags(decision)
    square = [[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]]
    decision = step(observation(place, OTHERS, (-5.0, 0.0)), polygons_m=square)
    assert decision.velocity_ned_m_s[0] > 0.0
    assert "violation" in flags(decision)


def test_on_the_border_of_an_obstacle_and_in_its_very_middle_the_way_out_is_defined() -> None:
    square = [[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]]
    assert step(observation((1.0, 0.0), OTHERS, EVADER), polygons_m=square).velocity_ned_m_s[0] > 0.0
    assert np.hypot(*step(observation((0.0, 0.0), OTHERS, EVADER, [(0.0, 0.0, 1.0)])).velocity_ned_m_s[:2]) > 0.9


def test_without_a_cell_it_goes_to_the_evader_and_does_not_stay() -> None:
    outside = observation((-9.0, 0.0), [(4.0, 0.2), (4.0, -2.0), (6.5, 1.0)], EVADER)
    decision = step(outside, box_half_min_m=0.5)
    first = decision.velocity_ned_m_s
    planner = pursuer(box_half_min_m=0.5)
    for tick in range(200):
        seen = observation((-9.0, 0.0), [(4.0, 0.2), (4.0, -2.0), (7.0, 1.0)], (5.2, 0.1), t_s=0.1 * tick)
        decision = planner.step(seen)
    assert "empty cell" in flags(decision)
    assert decision.velocity_ned_m_s[0] > 0.9
    assert first[0] > 0.9


@pytest.mark.parametrize(("mates", "can"), [([], False), ([(9.0, 1.0)], False), ([(9.0, 1.0), (4.0, 8.0)], True)])
def test_one_or_two_chase_and_say_that_they_cannot_encircle(mates: list[tuple[float, float]], can: bool) -> None:
    decision = step(observation((0.0, 0.0), mates, EVADER))
    assert ("cannot encircle" in flags(decision)) != can
    assert can or decision.velocity_ned_m_s[0] > 0.5
    assert chase([(0.0, 0.0), *mates], EVADER, seconds=15.0).captured_s is not None


def test_pursuers_in_a_row_encircle_nobody() -> None:
    decision = step(observation((0.0, 0.0), [(-2.0, 0.0), (9.0, 0.0)], EVADER))
    assert decision.diagnostics["hull_distance_m"] == 0.0
    assert decision.mode == "encircle"
    assert not decision.diagnostics["encircled"]


def test_a_wall_that_is_not_convex_is_told() -> None:
    dented = [[[20.0, 0.0], [24.0, 0.0], [24.0, 4.0], [22.0, 1.0]]]
    assert any(
        "polygon 0 is not convex" in flag for flag in flags(step(observation((0.0, 0.0), OTHERS, EVADER), polygons_m=dented))
    )


def test_a_capture_that_is_a_collision_is_told() -> None:
    assert "capture by contact" in flags(step(observation((0.0, 0.0), OTHERS, EVADER), evader_radius_m=0.9))


def test_too_many_for_the_capture_radius_are_told() -> None:
    crowd = [(6.0 * math.cos(k), 6.0 * math.sin(k)) for k in range(40)]
    assert "crowded" in flags(step(observation((0.0, 7.0), crowd, EVADER)))
    assert "crowded" not in flags(step(observation((0.0, 7.0), crowd[:6], EVADER)))


def test_a_faster_evader_is_chased_without_a_promise() -> None:
    decision = step(observation((0.0, 0.0), OTHERS, EVADER), evader_speed_assumed_m_s=1.2)
    assert "no guarantee" in flags(decision)


def test_an_evader_that_is_not_seen_is_waited_for_then_searched_then_given_up() -> None:
    planner = pursuer()
    ring = [(8.0, 3.0), (8.0, -3.0)]

    def at(t_s: float, age_s: float) -> Decision:
        return planner.step(observation((0.0, 0.0), ring, EVADER, t_s=t_s, evader_age_s=age_s))

    before = at(0.0, 0.0).diagnostics["box_half_m"]
    fresh = at(0.1, 0.1).diagnostics["box_half_m"]
    stale = at(0.2, 2.0).diagnostics["box_half_m"]
    assert fresh[0] == pytest.approx(before[0] - 0.1)  # type: ignore[index]
    assert stale == fresh, "it does not shrink around a guess"
    searching = at(5.0, 5.0)
    assert (searching.mode, searching.reason) == ("search", "the target was last seen 5.0 s ago")
    assert tuple(searching.goal_ned_m[:2]) == EVADER  # type: ignore[index]
    guessed = observation(EVADER, ring, EVADER, evader_velocity=(0.5, 0.0), evader_age_s=6.0)
    at_its_place = pursuer(vehicle="multirotor").step(guessed)
    assert at_its_place.mode == "search", "nobody captures a guess"
    assert at_its_place.velocity_ned_m_s[0] == pytest.approx(0.0, abs=1e-6), "it waits, and does not fly on with it"
    lost = at(10.0, 10.0)
    assert lost.mode == "hold"
    assert not lost.velocity_ned_m_s.any()
    assert planner.step(observation((0.0, 0.0), ring, t_s=10.1)).mode == "hold"


def test_while_it_holds_it_still_leaves_a_teammates_room() -> None:
    assert step(observation((0.0, 0.0), [(0.2, 0.0)])).velocity_ned_m_s[0] < 0.0


def test_a_silent_teammate_is_an_obstacle_that_grows_then_nothing() -> None:
    def towards(age_s: float) -> float:
        decision = step(observation((0.0, 0.0), [member("p2", 0.0, (3.0, 0.0), age_s=age_s), *OTHERS], (20.0, 0.0)))
        return float(decision.diagnostics["slack_m"])  # type: ignore[arg-type]

    assert towards(0.0) == pytest.approx(1.5 - 0.15)
    assert towards(0.5) == pytest.approx(1.5 - 0.15 - 0.5), "half of the room, less what it may have flown"
    assert towards(2.0) == pytest.approx(3.0 - 0.3 - 2.0), "all of the room before where it may be"
    assert towards(3.5) == pytest.approx(3.0 - 0.3 - 3.0)
    assert towards(10.0) > 2.0, "forgotten"


def test_a_silent_teammate_encloses_nobody() -> None:
    def hull(age_s: float) -> float:
        ring = [member("p2", 0.0, (9.0, 5.0), age_s=age_s), (9.0, -5.0)]
        return float(step(observation((0.0, 0.0), ring, EVADER)).diagnostics["hull_distance_m"])  # type: ignore[arg-type]

    assert hull(0.2) < 0.0 < hull(3.0)


def test_who_is_unheard_and_an_evader_that_is_unseen_are_told() -> None:
    def told(mate_age_s: float, evader_age_s: float) -> list[str]:
        ring = [member("p2", 0.0, (9.0, 5.0), age_s=mate_age_s), (9.0, -5.0)]
        return flags(step(observation((0.0, 0.0), ring, EVADER, evader_age_s=evader_age_s)))

    assert told(0.9, 0.9) == []
    assert told(1.1, 0.9) == ["teammate unheard"]
    assert told(0.9, 1.1) == ["evader unseen"]


def test_a_leader_and_its_plan_change_nothing() -> None:
    seen = observation((0.0, 0.0), OTHERS, EVADER)
    led = replace(seen, assignment=Assignment(2.0, 9.0))
    assert step(led).velocity_ned_m_s.tolist() == step(seen).velocity_ned_m_s.tolist()


def test_a_moving_obstacle_is_kept_clear_of_by_what_it_may_sweep() -> None:
    def slack(speed: float) -> float:
        decision = step(observation((0.0, 0.0), OTHERS, (0.0, 1.5), [(3.0, 0.0, 0.5, -speed, 0.0)]))
        return float(decision.diagnostics["slack_m"])  # type: ignore[arg-type]

    assert slack(0.0) - slack(4.0) == pytest.approx(4.0 * 0.1 + 16.0 / 2000.0, abs=1e-6)
    moving, standing = ([(9.0, 9.0, 0.5, speed, 0.0)] for speed in (0.5, 0.0))
    assert "moving obstacle" in flags(step(observation((0.0, 0.0), OTHERS, EVADER, moving)))
    assert "moving obstacle" not in flags(step(observation((0.0, 0.0), OTHERS, EVADER, standing)))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_messages_that_are_nonsense_are_left_out(bad: float) -> None:
    good = step(observation((0.0, 0.0), OTHERS, EVADER, [(2.0, 1.0, 0.5)]))
    mates = [member("p9", 0.0, (bad, 1.0)), *OTHERS]
    found = step(observation((0.0, 0.0), mates, EVADER, [(bad, 0.0, 1.0), (2.0, 1.0, 0.5), (1.0, 0.0, -1.0)]))
    assert found.velocity_ned_m_s.tolist() == good.velocity_ned_m_s.tolist()
    assert step(observation((0.0, 0.0), OTHERS, (bad, 0.0))).mode == "hold"


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"capture": {**CAPTURE, "radius_m": 0.1}}, r"capture.radius_m = 0.1: must be greater than 0.15, the pursuer's own body"),
        ({"capture": {**CAPTURE, "radius_m": math.nan}}, r"capture.radius_m = nan"),
        ({"evader_radius_m": -0.1}, r"evader_radius_m = -0.1"),
        (
            {"flight_area_m": [0.0, 0.0, 5.0, -1.0]},
            r"flight_area_m = .*must be least north, least east, greatest north, greatest east",
        ),
        ({"control_period_s": 0.0}, r"control_period_s = 0.0"),
        ({"polygons_m": [[[0.0, 0.0], [0.0, 0.0]]]}, r"polygon 0: its corners are one place"),
        ({"mate_silent_s": 0.5}, r"mate_silent_s = 0.5 must be at least mate_stale_s = 1.0"),
        ({"target_lost_s": 2.0}, r"must follow one another"),
        ({"shrinking": 1}, r"shrinking is not a parameter; did you mean 'shrink'"),
    ],
)
def test_what_cannot_be_is_one_clear_sentence(parameters: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        pursuer(**parameters)  # type: ignore[arg-type]


VEHICLES = ("single-integrator", "multirotor", "unicycle", "triple-integrator")
TRIANGLE = np.array(((-1.0, -1.0), (1.0, -1.0), (0.5, 1.0)))
AGES_S = (0.0, 0.0, 0.4, 2.0, 5.0, 20.0)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_world_is_too_strange(seed: int) -> None:
    """Whatever is seen, three times in a row: a finite velocity within the limit. `--hypothesis-profile=worlds`: 10 000 of it."""
    random = np.random.default_rng(seed)

    def places(count: int) -> np.ndarray:
        return np.round(random.uniform(-1.0, 1.0, (count, 2)) * span, 2)  # rounded: some are in one place

    span = random.choice((0.0, 0.1, 0.3, 3.0, 30.0))
    known: dict[str, object] = {"vehicle": str(random.choice(VEHICLES)), "shrink": str(random.choice(("latch", "reopen", "eq8")))}
    if random.random() < 0.3:
        known["polygons_m"] = [(places(1) + TRIANGLE).tolist()]
    if random.random() < 0.3:
        known["flight_area_m"] = [-2.0, -2.0, 2.0, 2.0]
    planner = pursuer(str(random.choice(ENCIRCLEMENT)), limits=replace(LIMITS, jerk_max_m_s3=1e4), **known)
    team = places(random.integers(1, 8))
    for tick in range(3):
        discs = [(*place, random.uniform(-0.1, 2.0), *random.normal(0.0, 0.5, 2)) for place in places(random.integers(0, 6))]
        mates = [
            member(f"p{i}", 0.0, place, tuple(random.normal(0.0, 1.0, 2)), "capture" if i == 4 else "", random.choice(AGES_S))
            for i, place in enumerate(team[1:])
        ]
        evader = None if random.random() < 0.05 else places(1)[0]
        velocity = tuple(random.normal(0.0, 0.5, 2))
        seen = observation(
            team[0], mates, evader, discs, t_s=0.1 * tick, velocity=velocity, yaw_rad=random.uniform(-4.0, 4.0),
            evader_velocity=tuple(random.normal(0.0, 1.0, 2)), evader_age_s=random.choice(AGES_S),
        )  # fmt: skip
        decision = planner.step(seen)
        assert np.isfinite(decision.velocity_ned_m_s).all()
        assert math.isfinite(decision.yaw_rad)
        assert np.hypot(*decision.velocity_ned_m_s[:2]) <= 1.0 + 1e-9
        team = team + 0.1 * random.normal(0.0, 0.5, team.shape)
