"""Prediction, meeting and polygon: the properties of the specification's last section, and its test values."""

from __future__ import annotations

import itertools
import math
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.planning.meeting import Runners, driving_s, meeting_of, rest_turn_s, turning_s
from flightapp.planning.polygon import Bodies, assign_slots, free_ring, places_on_ring_m, slot_bearings_rad
from flightapp.planning.prediction import Path, TrackHistory, fit_track, predicted_path

FEW = settings(max_examples=25, deadline=None)
OPEN = np.zeros((0, 3))
rates = st.floats(-1.0, 1.0)
alphas = st.floats(0.1, 4.0)
angles = st.floats(-math.pi, math.pi)


@pytest.mark.parametrize(
    ("angle", "rate", "alpha", "expected"),
    [(0.66, 0.46, 0.91, 1.3417), (-3.0, 0.63, 1.39, 4.2077), (0.85, -0.46, 0.25, 6.3534), (0.1, 0.8, 0.5, 3.6785)],
)
def test_turning_takes_as_long_as_a_bang_bang_simulation(angle: float, rate: float, alpha: float, expected: float) -> None:
    assert float(turning_s(np.array(angle), np.array(rate), math.pi / 3.0, alpha)) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(("alpha", "expected"), [(0.2, 13.532), (0.419, 9.373), (0.698, 7.500), (3.0, 5.198)])
def test_a_quarter_and_a_half_turn_from_rest_to_rest(alpha: float, expected: float) -> None:
    both = rest_turn_s(0.5 * math.pi, math.pi / 3.0, alpha) + rest_turn_s(math.pi, math.pi / 3.0, alpha)
    assert both == pytest.approx(expected, abs=2e-3)


@FEW
@given(angles, rates, alphas, st.floats(0.2, 2.0), st.floats(0.0, 1.0))
def test_turning_further_takes_longer_and_a_nimbler_vehicle_never_does(
    angle: float, rate: float, alpha: float, top: float, more: float
) -> None:
    """Further is measured from where the present turn would end: before that, a vehicle has to come back."""

    def time_s(way: float, top: float = top, alpha: float = alpha) -> float:
        return float(turning_s(np.array(way), np.array(min(max(rate, -top), top)), top, alpha))

    held = min(max(rate, -top), top)
    stop = held * abs(held) / (2.0 * alpha)
    sign = 1.0 if angle >= stop else -1.0
    assert time_s(angle + sign * more) >= time_s(angle) - 1e-9
    assert time_s(angle + 1e-9) == pytest.approx(time_s(angle), abs=1e-3)
    at_rest = [float(turning_s(np.array(angle), np.array(0.0), *limits)) for limits in ((top, alpha), (2.0 * top, alpha))]
    assert at_rest[1] <= at_rest[0] + 1e-9
    assert float(turning_s(np.array(angle), np.array(0.0), top, 2.0 * alpha)) <= at_rest[0] + 1e-9


@FEW
@given(angles, rates, alphas)
def test_turning_is_no_shorter_than_at_full_rate_and_the_same_to_both_sides(angle: float, rate: float, alpha: float) -> None:
    here = float(turning_s(np.array(angle), np.array(rate), 1.0, alpha))
    assert here >= abs(angle) - 1e-9
    assert here == pytest.approx(float(turning_s(np.array(-angle), np.array(-rate), 1.0, alpha)))
    quick, slow = (float(turning_s(np.array(angle), np.array(0.0), 1.0, one)) for one in (alpha, 0.5 * alpha))
    assert quick <= slow + 1e-9


@FEW
@given(st.floats(0.0, 200.0), st.floats(0.0, 2.0), st.floats(0.1, 5.0))
def test_driving_grows_with_the_way_and_is_continuous_where_the_top_speed_is_reached(way: float, speed: float, a: float) -> None:
    def time_s(distance: float) -> float:
        return float(driving_s(np.array(distance), np.array(speed), np.array(2.0), a))

    assert time_s(way) >= way / 2.0 - 1e-9
    assert time_s(way + 0.1) > time_s(way)
    border = (4.0 - speed**2) / (2.0 * a)
    assert time_s(border) == pytest.approx(time_s(border + 1e-9), abs=1e-6)


@FEW
@given(st.floats(0.0, 200.0), st.floats(0.0, 2.0), st.floats(0.1, 5.0), st.floats(2.0, 6.0))
def test_driving_takes_a_stronger_or_faster_vehicle_no_longer(way: float, speed: float, a: float, top: float) -> None:
    def time_s(top: float, a: float) -> float:
        return float(driving_s(np.array(way), np.array(speed), np.array(top), a))

    assert time_s(top + 0.5, a) <= time_s(top, a) + 1e-9
    assert time_s(top, 1.5 * a) <= time_s(top, a) + 1e-9


@FEW
@given(st.lists(st.tuples(st.floats(-200, 200), st.floats(-200, 200)), min_size=3, max_size=5), st.floats(0.2, 2.0))
def test_all_that_are_not_late_are_in_time_at_the_meeting_and_not_all_of_them_one_step_before(
    starts: list[tuple[float, float]], speed: float
) -> None:
    path = Path(0.0, 1.0, np.arange(200.0)[:, None] * np.array([speed, 0.0]), np.full(200, 0.05))
    count = len(starts)
    runners = Runners(np.array(starts), np.zeros(count), np.zeros(count), np.full(count, 2.0), 0.5, 1.0, 0.5)
    meeting = meeting_of(runners, path)
    times = runners.times_s(path.places_m)[~meeting.late]
    if meeting.reachable:
        assert (times[:, meeting.index] <= meeting.index).all()
        margin_s = 0.5 + 2.0 * 0.05 / 2.0
        assert meeting.index == 0 or (times[:, meeting.index - 1] + margin_s > meeting.index - 1).any()


@pytest.mark.parametrize(
    ("gamma", "bearing_deg", "meets"),
    [(0.5, 20.0, True), (0.5, 40.0, False), (0.5, 170.0, False), (1.0, 60.0, True), (1.0, 100.0, False), (1.5, 170.0, True)],
)
def test_who_meets_a_straight_target_is_told_by_its_bearing(gamma: float, bearing_deg: float, meets: bool) -> None:
    """gamma = 0.5: within asin(0.5) = 30 degrees about its course; as fast: ahead of it; faster: always."""
    path = Path(0.0, 0.5, np.arange(6000.0)[:, None] * np.array([0.5, 0.0]), np.zeros(6000))
    at = 100.0 * np.array([math.cos(math.radians(bearing_deg)), math.sin(math.radians(bearing_deg))])
    speeds = np.full(3, gamma)
    runners = Runners(np.repeat(at[None], 3, axis=0), np.full(3, math.pi), speeds, speeds, 5.0, 3.0, 9.0)
    assert meeting_of(runners, path).reachable is meets


@FEW
@given(st.lists(st.tuples(st.floats(-200, 200), st.floats(-200, 200)), min_size=4, max_size=6), st.floats(0.2, 1.5))
def test_one_more_that_is_to_be_there_never_makes_the_meeting_earlier(starts: list[tuple[float, float]], speed: float) -> None:
    """At three quarters of their speed all catch up within the path's 800 s, from the farthest start in 450 s."""
    path = Path(0.0, 1.0, np.arange(800.0)[:, None] * np.array([speed, 0.0]), np.full(800, 0.05))

    def index(count: int) -> int:
        still = np.zeros(count)
        meeting = meeting_of(Runners(np.array(starts[:count]), still, still, np.full(count, 2.0), 0.5, 1.0, 0.5), path)
        assert meeting.reachable
        return meeting.index if not meeting.late.any() else -1

    before, after = index(len(starts) - 1), index(len(starts))
    assert after == -1 or after >= before


@FEW
@given(st.integers(1, 9), angles, st.floats(0.1, 30.0), st.floats(-50, 50), st.floats(-50, 50))
def test_slots_are_even_on_the_circle_and_neighbours_keep_their_distance(
    count: int, heading: float, wanted: float, n: float, e: float
) -> None:
    bodies = Bodies(2.0, 2.0, 5.0)
    ring = free_ring(np.array([n, e]), heading, count, wanted, bodies, OPEN)
    assert np.allclose(np.hypot(*(ring.places_m - (n, e)).T), ring.radius_m, rtol=0.0, atol=1e-9)
    assert np.allclose(np.diff(ring.bearings_rad), 2.0 * math.pi / count)
    for a, b in itertools.combinations(ring.places_m, 2):
        assert math.dist(a, b) >= 2.0 * 2.0 + 5.0 - 1e-9
    assert bodies.slots_max(ring.radius_m) >= count
    turned = places_on_ring_m(np.zeros(2), 3.0, slot_bearings_rad(count, heading + 1.0))
    plain = places_on_ring_m(np.zeros(2), 3.0, slot_bearings_rad(count, heading))
    rotation = np.array([[math.cos(1.0), -math.sin(1.0)], [math.sin(1.0), math.cos(1.0)]])
    assert np.allclose(turned, plain @ rotation.T)


def test_six_fit_at_nine_metres() -> None:
    assert Bodies(2.0, 2.0, 5.0).slots_max(9.0) == 6


@FEW
@given(st.lists(st.tuples(st.floats(-99, 99), st.floats(-99, 99)), min_size=2, max_size=5, unique=True), angles)
def test_everybody_gets_a_slot_of_its_own_and_no_two_ways_cross(starts: list[tuple[float, float]], heading: float) -> None:
    slots = places_on_ring_m(np.zeros(2), 10.0, slot_bearings_rad(len(starts), heading))
    names = [f"p{k}" for k in range(len(starts))]
    chosen = assign_slots(np.array(starts), slots, names, {})
    assert sorted(slot for slot in chosen if slot is not None) == list(range(len(starts)))
    ends = [slots[slot] for slot in chosen if slot is not None]
    for (a, b), (c, d) in itertools.combinations(zip(starts, ends, strict=True), 2):
        assert math.dist(a, b) + math.dist(c, d) <= math.dist(a, d) + math.dist(c, b) + 1e-6


@FEW
@given(
    st.lists(st.tuples(st.floats(-99, 99), st.floats(-99, 99)), min_size=2, max_size=5, unique=True),
    angles,
    st.randoms(use_true_random=False),
)
def test_the_total_way_is_no_longer_than_by_the_papers_rule_and_the_order_of_the_vehicles_does_not_matter(
    starts: list[tuple[float, float]], heading: float, random: Random
) -> None:
    """The paper counts slots the one way round and sorts vehicles the other way round."""
    count = len(starts)
    slots = places_on_ring_m(np.zeros(2), 10.0, slot_bearings_rad(count, heading))

    def total(order: list[int]) -> float:
        chosen = assign_slots(np.array([starts[k] for k in order]), slots, [f"p{k}" for k in order], {})
        return sum(math.dist(starts[k], slots[slot]) for k, slot in zip(order, chosen, strict=True) if slot is not None)

    plain = total(list(range(count)))
    shuffled = random.sample(range(count), count)
    assert total(shuffled) == pytest.approx(plain)
    around = sorted(range(count), key=lambda k: (heading - math.atan2(starts[k][1], starts[k][0])) % (2.0 * math.pi))
    papers = sum(math.dist(starts[k], slots[slot]) for slot, k in enumerate(around))
    assert plain <= papers + 1e-9


def test_slots_are_exchanged_only_for_a_tenth_of_the_way() -> None:
    slots = np.array([[0.0, 0.0], [10.0, 0.0]])
    near = np.array([[4.9, 50.0], [5.1, 50.0]])
    assert assign_slots(near, slots, ["p1", "p2"], {"p1": 1, "p2": 0}) == [1, 0]
    far = np.array([[0.0, 1.0], [10.0, 1.0]])
    assert assign_slots(far, slots, ["p1", "p2"], {"p1": 1, "p2": 0}) == [0, 1]


def test_slots_inside_obstacles_turn_grow_or_are_left_out() -> None:
    bodies = Bodies(0.3, 0.3, 0.7)
    one = np.array([[5.0, 0.0, 0.5]])
    turned = free_ring(np.zeros(2), 0.0, 5, 5.0, bodies, one)
    assert len(turned.places_m) == 5
    assert min(math.dist(place, (5.0, 0.0)) for place in turned.places_m) >= 0.8
    half = np.array([[40.0, 0.0, 38.0]])
    assert 0 < len(free_ring(np.zeros(2), 0.0, 5, 5.0, bodies, half).places_m) < 5
    everywhere = np.array([[0.0, 0.0, 99.0]])
    assert len(free_ring(np.zeros(2), 0.0, 5, 5.0, bodies, everywhere).places_m) == 5


@FEW
@given(st.integers(1, 2), st.floats(-2, 2), st.floats(-2, 2), st.floats(-0.05, 0.05), angles)
def test_a_polynomial_track_is_predicted_exactly_and_turns_and_moves_with_the_frame(
    degree: int, vn: float, ve: float, a: float, turn: float
) -> None:
    times = np.arange(0.0, 10.0, 0.5)
    places = np.stack((1.0 + vn * times + (degree - 1) * a * times**2, 2.0 + ve * times), axis=1)
    fit = fit_track(times, places, 9.5)
    assert fit is not None
    assert np.allclose(fit.at(times), places, atol=1e-2)
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    away = np.array([30.0 * turn, -7.0])
    other = fit_track(times, places @ rotation.T + away, 9.5)
    assert other is not None
    assert other.degree == fit.degree
    ahead = np.array([12.0])
    assert np.allclose(other.at(ahead), fit.at(ahead) @ rotation.T + away, atol=1e-6)


@FEW
@given(st.lists(st.tuples(st.floats(0, 30), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=1, max_size=12))
def test_no_prediction_is_faster_than_the_target_or_not_finite(samples: list[tuple[float, float, float]]) -> None:
    rows = np.array(samples)
    path = predicted_path(fit_track(rows[:, 0], rows[:, 1:], 30.0), np.zeros(2), 30.0, 0.5, 60, 3.0)
    assert np.isfinite(path.places_m).all()
    assert np.isfinite(path.deviations_m).all()
    assert (np.hypot(*np.diff(path.places_m, axis=0).T) <= 1.5 + 1e-9).all()


def test_samples_repeated_disordered_not_finite_or_from_the_future_do_no_harm() -> None:
    times = np.array([2.0, 1.0, 1.0, math.nan, 0.0, 99.0])
    places = np.array([[2.0, 0.0], [7.0, 7.0], [1.0, 0.0], [0.0, 0.0], [0.0, 0.0], [50.0, 50.0]])
    fit = fit_track(times, places, 2.0)
    assert fit is not None
    assert np.allclose(fit.at(np.array([3.0])), [[3.0, 0.0]], atol=1e-6)
    assert fit_track(np.zeros(0), np.zeros((0, 2)), 0.0) is None
    pair = fit_track(np.array([0.0, 2.0]), np.array([[0.0, 0.0], [2.0, 4.0]]), 2.0)
    assert pair is not None
    assert pair.degree == 1
    assert np.allclose(pair.at(np.array([4.0])), [[4.0, 8.0]], atol=1e-6)
    standing = fit_track(np.array([5.0]), np.array([[3.0, 4.0]]), 5.0)
    assert standing is not None
    assert predicted_path(standing, np.array([3.0, 4.0]), 5.0, 1.0, 5, 2.0).heading_rad(5) is None


def test_a_turn_cuts_the_window_so_that_the_new_course_counts() -> None:
    history = TrackHistory()
    history.note(1e6, (0.0, 0.0), 0.0)  # a stamp from the far future does not make it deaf
    for k in range(41):
        t_s = 0.25 * k
        history.note(t_s, (2.0 * t_s, 0.0), t_s)
    for k in range(1, 17):
        history.note(10.0 + 0.25 * k, (20.0, 0.5 * k), 10.0 + 0.25 * k)
    fit = history.fit(14.0)
    assert fit is not None
    path = predicted_path(fit, np.array([20.0, 8.0]), 14.0, 0.5, 20, 2.0)
    heading = path.heading_rad(20)
    assert heading is not None
    assert abs(heading - 0.5 * math.pi) < 0.2
