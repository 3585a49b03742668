"""The clock of a log is recovered from the velocity that both sides recorded."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.analysis.ulog.alignment import Alignment, Motion, align

DRIFT = 50e-6
FLEET_S = 1_795_347_064.0
"""Fleet time is Unix time: offsets between the clocks are that large."""


def wander(t_s: np.ndarray, seed: int) -> np.ndarray:
    """A flight's velocity: smooth, never the same twice."""
    random = np.random.default_rng(seed)
    knots = np.arange(t_s[0] - 4.0, t_s[-1] + 4.0, 2.0)
    noise = random.normal(0.0, 2.0, (len(knots), 3))
    smooth = np.column_stack([np.convolve(np.interp(t_s, knots, noise[:, axis]), np.ones(20) / 20, "same") for axis in range(3)])
    return np.asarray(smooth)


def recorded(length_s: float, offset_s: float, seed: int = 1, noise_m_s: float = 0.05) -> tuple[Motion, Motion]:
    """(ours, the log's) of one flight: 50 Hz and 10 Hz, each with noise of its own; the log's clock is offset and drifts."""
    random = np.random.default_rng(seed)
    true_s = np.arange(0.0, length_s, 0.02)
    velocity = wander(true_s, seed)
    ours = Motion(FLEET_S + true_s, velocity + random.normal(0.0, noise_m_s, velocity.shape))
    log_s = (true_s - offset_s)[::5] / (1.0 + DRIFT)
    return ours, Motion(log_s, velocity[::5] + random.normal(0.0, noise_m_s, velocity[::5].shape))


def errors_s(found: Alignment, offset_s: float, log: Motion) -> np.ndarray:
    """Of the recovered fleet time at the beginning, the middle and the end of the log."""
    t_s = np.array([log.t_s[0], 0.5 * (log.t_s[0] + log.t_s[-1]), log.t_s[-1]])
    return np.asarray(found.to_reference(t_s) - (FLEET_S + offset_s + t_s * (1.0 + DRIFT)))


def test_minutes_of_offset_and_50_ppm_of_drift_are_recovered_over_a_flight_of_twenty_minutes() -> None:
    ours, log = recorded(1200.0, -437.0)
    found = align(ours, log)
    assert isinstance(found, Alignment)
    assert np.abs(errors_s(found, -437.0, log)).max() < 0.005
    assert found.drift_ppm == pytest.approx(50.0, abs=5.0)
    assert found.drift_sigma_ppm is not None
    assert abs(found.drift_ppm - 50.0) < 4.0 * found.drift_sigma_ppm
    assert 0.0 < found.offset_sigma_s < 0.005


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000), offset_s=st.floats(-1800.0, 1800.0), length_s=st.floats(30.0, 120.0))
def test_any_short_flight_is_aligned_to_a_control_period(seed: int, offset_s: float, length_s: float) -> None:
    ours, log = recorded(length_s, offset_s, seed)
    found = align(ours, log)
    assert isinstance(found, Alignment)
    assert np.abs(errors_s(found, offset_s, log)).max() < 0.02


def test_a_log_that_covers_a_part_of_the_flight_is_aligned() -> None:
    ours, log = recorded(120.0, 300.0)
    part = slice(300, 900)
    found = align(ours, Motion(log.t_s[part], log.velocity_ned_m_s[part]))
    assert isinstance(found, Alignment)
    assert np.abs(errors_s(found, 300.0, Motion(log.t_s[part], log.velocity_ned_m_s[part]))).max() < 0.04


def test_the_clock_of_another_flight_is_not_made_up() -> None:
    ours, _ = recorded(120.0, 0.0, seed=1)
    _, other = recorded(120.0, 0.0, seed=2)
    assert "no common motion" in str(align(ours, other))


def test_a_vehicle_that_stood_still_tells_no_clock() -> None:
    t_s = np.arange(0.0, 60.0, 0.1)
    still = Motion(t_s, np.zeros((len(t_s), 3)))
    ours, _ = recorded(60.0, 0.0)
    assert align(ours, still) == "the vehicle hardly moved"


def test_a_motion_that_repeats_itself_is_ambiguous() -> None:
    t_s = np.arange(0.0, 120.0, 0.1)
    circle = np.column_stack([np.cos(t_s), np.sin(t_s), np.zeros(len(t_s))])
    assert align(Motion(t_s, circle), Motion(t_s, circle)) == "the motion repeats itself: more than one offset fits"
