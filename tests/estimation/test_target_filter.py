from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.estimation.measurement import seen, told
from flightapp.estimation.target_filter import MotionModel, TargetFilter, TargetFilterParameters

coordinate = st.floats(-60, 60)
anything = st.floats(allow_nan=True, allow_infinity=True)
measurements = st.tuples(st.floats(0, 8), coordinate, coordinate, st.one_of(st.none(), st.floats(-6, 6)), st.floats(0.02, 2))


def _feed(target: TargetFilter, item: tuple[float, float, float, float | None, float]) -> bool:
    t_s, north, east, speed, sigma = item
    velocity = None if speed is None else np.array([speed, 0.5, 0.0])
    return target.update(t_s, np.array([north, east, -5.0]), velocity, sigma, 0.3)


def _truth(t_s: float) -> tuple[np.ndarray, np.ndarray]:
    velocity = np.array([-2.0, 0.7, 0.1])
    return np.array([50.0, -5.0, -5.0]) + t_s * velocity, velocity


@settings(max_examples=60, deadline=None)
@given(st.lists(measurements, min_size=1, max_size=30), st.floats(0, 30))
def test_the_covariance_is_symmetric_and_positive_and_everything_finite(
    items: list[tuple[float, float, float, float | None, float]], later_s: float
) -> None:
    target = TargetFilter()
    for item in items:
        assert _feed(target, item)
        track = target.predict(8.0 + later_s)
        assert track is not None
        assert np.isfinite([*track.position_ned_m, *track.velocity_ned_m_s, track.age_s]).all()
        assert np.array_equal(track.covariance, track.covariance.T)
        assert np.linalg.eigvalsh(track.covariance).min() > 0.0


@settings(max_examples=60, deadline=None)
@given(st.lists(measurements, min_size=2, max_size=25), st.randoms(use_true_random=False))
def test_the_order_of_arrival_does_not_matter(
    items: list[tuple[float, float, float, float | None, float]], random: object
) -> None:
    shuffled = list(items)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    one, two = TargetFilter(), TargetFilter()
    for item in sorted(items, key=lambda item: item[0]):
        _feed(one, item)
    for item in shuffled:
        _feed(two, item)
    first, second = one.predict(9.0), two.predict(9.0)
    assert first is not None
    assert second is not None
    assert np.array_equal(first.position_ned_m, second.position_ned_m)
    assert np.array_equal(first.covariance, second.covariance)
    assert first.age_s == second.age_s


@settings(max_examples=100, deadline=None)
@given(anything, anything, anything, anything, anything)
def test_bad_numbers_are_refused_and_change_nothing(
    t_s: float, north: float, speed: float, sigma: float, speed_sigma: float
) -> None:
    target = TargetFilter()
    target.update(0.0, np.array([1.0, 2.0, -5.0]), None, 0.1, 0.1)
    before = target.predict(1.0)
    taken = target.update(t_s, np.array([north, 0.0, -5.0]), np.array([speed, 0.0, 0.0]), sigma, speed_sigma)
    if not all(map(math.isfinite, (t_s, north, speed, sigma, speed_sigma))):
        assert not taken
    after = target.predict(1.0)
    assert before is not None
    if not taken:
        assert after is not None
        assert np.array_equal(before.position_ned_m, after.position_ned_m)
    elif after is not None:
        assert np.isfinite(after.position_ned_m).all()
        assert np.isfinite(after.covariance).all()


def test_a_gap_is_bridged_with_growing_uncertainty_and_age() -> None:
    target = TargetFilter()
    for step in range(40):
        position, velocity = _truth(0.1 * step)
        target.update(0.1 * step, position, velocity, 0.05, 0.1)
    spreads = []
    for gap in (0.0, 0.5, 1.0, 2.0):
        track = target.predict(0.1 * 39 + gap)
        assert track is not None
        assert track.age_s == pytest.approx(gap)
        assert np.linalg.norm(track.position_ned_m - _truth(3.9 + gap)[0]) < 0.05 + 0.05 * gap
        spreads.append(np.trace(track.covariance))
    assert all(a < b for a, b in itertools.pairwise(spreads))


def test_errors_are_as_large_as_the_covariance_says() -> None:
    """NEES over simulated motion with the filter's own model: mean within the 99.9 % band about 6."""
    rng, density, dt = np.random.default_rng(7), 0.5, 0.1
    parameters = TargetFilterParameters(models=(MotionModel(is_turn=False, acceleration_density_m2_s3=density, probability=1.0),))
    noise = np.linalg.cholesky(density * np.kron(np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), np.eye(3)))
    scores = []
    for _ in range(60):
        target, state = TargetFilter(parameters), np.array([40.0, 0, -5, -2, 1, 0])
        for step in range(40):
            state[:3] += dt * state[3:]
            state += noise @ rng.standard_normal(6)
            velocity = state[3:] + 0.2 * rng.standard_normal(3) if step % 2 else None
            target.update(step * dt, state[:3] + 0.1 * rng.standard_normal(3), velocity, 0.1, 0.2)
        track = target.predict(39 * dt)
        assert track is not None
        error = np.concatenate((track.position_ned_m, track.velocity_ned_m_s)) - state
        scores.append(float(error @ np.linalg.solve(track.covariance, error)))
    assert 4.7 < np.mean(scores) < 7.6


def test_an_outlier_is_left_out_and_a_real_jump_is_followed() -> None:
    target = TargetFilter()
    for step in range(20):
        target.update(0.1 * step, _truth(0.1 * step)[0], None, 0.1, 1.0)
    target.update(2.0, _truth(2.0)[0] + 30.0, None, 0.1, 1.0)
    track = target.predict(2.0)
    assert track is not None
    assert np.linalg.norm(track.position_ned_m - _truth(2.0)[0]) < 0.3
    assert track.age_s == pytest.approx(0.1)
    for step in range(21, 25):
        target.update(0.1 * step, _truth(0.1 * step)[0] + 30.0, None, 0.1, 1.0)
    track = target.predict(2.4)
    assert track is not None
    assert np.linalg.norm(track.position_ned_m - _truth(2.4)[0] - 30.0) < 0.5


def test_before_the_first_measurement_there_is_no_track_and_reset_forgets() -> None:
    target = TargetFilter()
    assert target.predict(1.0) is None
    target.update(5.0, np.zeros(3), None, 0.1, 0.1)
    assert target.predict(4.9) is None
    assert target.predict(math.nan) is None
    assert target.predict(5.0) is not None
    target.reset()
    assert target.predict(5.0) is None


def test_what_is_older_than_the_ring_is_refused() -> None:
    target = TargetFilter(TargetFilterParameters(ring_length=5))
    for step in range(20):
        assert target.update(float(step), _truth(float(step))[0], None, 0.1, 1.0)
    assert not target.update(3.0, np.zeros(3), None, 0.1, 1.0)
    assert target.update(17.5, _truth(17.5)[0], None, 0.1, 1.0)


def test_after_a_long_gap_the_filter_starts_anew() -> None:
    target = TargetFilter()
    target.update(0.0, np.zeros(3), np.array([5.0, 0, 0]), 0.1, 0.1)
    target.update(30.0, np.array([1.0, 0, 0]), None, 0.1, 0.1)
    track = target.predict(30.0)
    assert track is not None
    assert track.position_ned_m.tolist() == [1.0, 0.0, 0.0]
    assert track.velocity_ned_m_s.tolist() == [0.0, 0.0, 0.0]


def test_a_turn_is_followed_around_where_one_straight_model_flies_on() -> None:
    """4 m/s around a circle of 4 m, then nothing for a second: a quarter of the circle ahead."""

    def at(t_s: float) -> np.ndarray:
        return np.array([4.0 * math.sin(t_s), 4.0 - 4.0 * math.cos(t_s), -5.0])

    def error_m(target: TargetFilter) -> float:
        random = np.random.default_rng(3)
        for step in range(61):
            t_s = 0.05 * step
            velocity = np.array([4.0 * math.cos(t_s), 4.0 * math.sin(t_s), 0.0]) + 0.2 * random.standard_normal(3)
            assert target.update(t_s, at(t_s) + 0.1 * random.standard_normal(3), velocity, 0.1, 0.2)
        track = target.predict(4.0)
        assert track is not None
        return float(np.linalg.norm(track.position_ned_m - at(4.0)))

    straight = error_m(TargetFilter(TargetFilterParameters(models=(MotionModel(False, 2.0, 1.0),))))
    assert straight > 1.5
    assert error_m(TargetFilter()) < 0.8 * straight


def _followed(until_s: float = 2.0) -> TargetFilter:
    target = TargetFilter()
    for step in range(round(until_s * 20) + 1):
        position, velocity = _truth(0.05 * step)
        target.update(0.05 * step, position, velocity, 0.1, 0.2)
    return target


def test_what_a_camera_sees_corrects_a_track_but_never_starts_one() -> None:
    target = TargetFilter()
    sighting = seen(0.0, 50.0, -5.0, 0.3, 0.2, 0.1)
    assert sighting is not None
    fit = target.take(sighting)
    assert fit is not None
    assert not fit.is_used
    assert target.predict(1.0) is None
    target = _followed()
    position, _ = _truth(2.5)
    sighting = seen(2.5, float(position[0]), float(position[1]), 0.3, 0.2, 0.1)
    assert sighting is not None
    fit = target.take(sighting)
    assert fit is not None
    assert fit.is_used
    track = target.predict(2.5)
    assert track is not None
    assert track.age_s == 0.0
    assert track.covariance[2, 2] > track.covariance[0, 0]  # height is not measured


def test_cameras_alone_hold_the_track_after_the_evader_falls_silent() -> None:
    target, random = _followed(), np.random.default_rng(5)
    for step in range(1, 80):
        position, _ = _truth(2.0 + 0.1 * step)
        noisy = position + 0.1 * random.standard_normal(3)
        sighting = seen(2.0 + 0.1 * step, float(noisy[0]), float(noisy[1]), 0.5, 0.2, 0.1)
        assert sighting is not None
        target.take(sighting)
    track = target.predict(9.9)
    assert track is not None
    assert np.linalg.norm((track.position_ned_m - _truth(9.9)[0])[:2]) < 0.3
    assert track.age_s < 0.15


@pytest.mark.parametrize(("aside_m", "silent_s"), [(3.0, 0.1), (0.0, 4.0)])
def test_what_may_be_something_else_is_left_out(aside_m: float, silent_s: float) -> None:
    """A tree beside the evader's way; and anything at all once nobody knows where the evader is."""
    target = _followed()
    position, _ = _truth(2.0 + silent_s)
    for repeat in range(10):
        sighting = seen(2.0 + silent_s + 0.001 * repeat, float(position[0]), float(position[1]) + aside_m, 0.0, 0.2, 0.1)
        assert sighting is not None
        fit = target.take(sighting)
        assert fit is not None
        assert not fit.is_used
    track = target.predict(2.1 + silent_s)
    assert track is not None
    assert track.age_s == pytest.approx(0.1 + silent_s)


def test_a_track_that_a_camera_leads_astray_is_given_up_for_what_the_evader_says() -> None:
    """Sightings that drift away with a wrong thing between the evader's own messages do not keep these out."""
    target = _followed()
    for step in range(1, 120):
        t_s = 2.0 + 0.05 * step
        position, velocity = _truth(t_s)
        sighting = seen(t_s, float(position[0]), float(position[1]) + 0.08 * step, 0.0, 0.3, 0.3)
        assert sighting is not None
        target.take(sighting)
        if step > 60:
            target.update(t_s, position, velocity, 0.1, 0.2)
    track = target.predict(8.0)
    assert track is not None
    assert np.linalg.norm(track.position_ned_m - _truth(8.0)[0]) < 0.5


def test_one_update_never_works_on_more_than_the_ring() -> None:
    target = TargetFilter(TargetFilterParameters(ring_length=10))
    for step in range(500):
        measurement = told(0.05 * step, *_truth(0.05 * step), 0.1, 0.2)
        assert measurement is not None
        target.take(measurement)
        assert len(target._measurements) <= 10
