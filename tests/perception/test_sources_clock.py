"""Capture times: never in the future, quick to learn, true over drift, wraps, resets and a host clock that is set."""

from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from perception.sources.clock_mapping import COUNTER_S, WINDOW_S, CaptureClock

PERIOD_S = 1 / 30
delays_s = st.lists(st.floats(0.002, 0.08), min_size=2, max_size=60)


def test_unix_stamps_give_the_age_of_a_frame() -> None:
    clock = CaptureClock()
    assert clock.capture_s(999.97, 50.0, age_s=0.03) == pytest.approx(49.97)
    assert clock.capture_s(1000.5, 50.01, age_s=-0.5) == 50.01


@pytest.mark.parametrize("step_s", [-3600.0, 3600.0])
def test_a_host_clock_that_is_set_does_not_make_frames_old_or_new(step_s: float) -> None:
    clock = CaptureClock()
    for k in range(30):
        clock.capture_s(1000.0 + k * PERIOD_S, 50.02 + k * PERIOD_S, age_s=0.02)
    captured_s = clock.capture_s(1000.0 + 30 * PERIOD_S, 50.03 + 30 * PERIOD_S, age_s=0.03 + step_s)
    assert captured_s == pytest.approx(50.02 + 30 * PERIOD_S, abs=1e-9)


def test_stamps_of_the_cameras_clock_follow_the_quickest_frame() -> None:
    clock = CaptureClock()
    captured_s = [
        clock.capture_s(3.0 + k * PERIOD_S, 10.0 + k * PERIOD_S + delay_s) for k, delay_s in enumerate([0.02, 0.005, 0.03, 0.01])
    ]
    assert captured_s[1:] == pytest.approx([10.005 + k * PERIOD_S for k in (1, 2, 3)])


@given(delays_s, st.floats(-1e6, 1e6))
def test_no_frame_is_later_than_its_arrival_nor_older_than_the_jitter(delays_s: list[float], origin_s: float) -> None:
    clock = CaptureClock()
    jitter_s = max(delays_s) - min(delays_s)
    for k, delay_s in enumerate(delays_s):
        arrival_s = 100.0 + k * PERIOD_S + delay_s
        captured_s = clock.capture_s(origin_s + k * PERIOD_S, arrival_s)
        assert arrival_s - jitter_s - 1e-6 <= captured_s <= arrival_s


@pytest.mark.parametrize("drift", [-100e-6, 100e-6])
@pytest.mark.parametrize("rate_hz", [6.0, 30.0])
def test_a_drifting_camera_clock_is_followed_for_an_hour(drift: float, rate_hz: float) -> None:
    clock, worst_s = CaptureClock(), 0.0
    for k in range(int(3600 * rate_hz)):
        true_s = k / rate_hz
        delay_s = 0.004 + 0.001 * (k % 7)
        captured_s = clock.capture_s(true_s * (1 + drift), true_s + delay_s)
        if true_s > WINDOW_S:
            worst_s = max(worst_s, abs(captured_s - (true_s + 0.004)))
    assert worst_s < 0.002


def test_the_counter_of_the_camera_may_wrap() -> None:
    clock = CaptureClock()
    start_s = COUNTER_S - 10 * PERIOD_S
    for k in range(60):
        arrival_s = 500.0 + k * PERIOD_S + (0.005 if k == 0 else 0.015)
        captured_s = clock.capture_s((start_s + k * PERIOD_S) % COUNTER_S, arrival_s)
        assert captured_s == pytest.approx(500.005 + k * PERIOD_S, abs=1e-6)


@given(delays_s, st.floats(10.0, 1e5), st.floats(-1e5, 1e5), st.booleans())
def test_a_camera_clock_that_starts_anew_is_learnt_anew(
    delays_s: list[float], before_s: float, leap_s: float, is_reset: bool
) -> None:
    looks_like_none_or_a_wrap = -1.0 <= leap_s <= 2.5 or abs(leap_s + COUNTER_S) < 3.0
    assume(is_reset or not looks_like_none_or_a_wrap)
    clock = CaptureClock()
    for k in range(30):
        clock.capture_s(before_s + k * PERIOD_S, 100.0 + k * PERIOD_S)
    if is_reset:
        clock.reset()
    jitter_s = max(delays_s) - min(delays_s)
    for k, delay_s in enumerate(delays_s):
        arrival_s = 102.0 + k * PERIOD_S + delay_s
        captured_s = clock.capture_s(before_s + 1.0 + leap_s + k * PERIOD_S, arrival_s)
        assert arrival_s - jitter_s - 1e-6 <= captured_s <= arrival_s


def test_one_mad_stamp_does_not_make_the_following_frames_old() -> None:
    clock = CaptureClock()
    for k in range(60):
        stamp_s = k * PERIOD_S + (500.0 if k == 30 else 0.0)
        arrival_s = 10.0 + k * PERIOD_S
        assert clock.capture_s(stamp_s, arrival_s) == pytest.approx(arrival_s, abs=1e-6)


def test_a_host_that_hung_sees_the_waiting_frames_as_old_as_they_are() -> None:
    clock = CaptureClock()
    for k in range(30):
        clock.capture_s(k * PERIOD_S, 10.0 + k * PERIOD_S)
    late_s = [clock.capture_s(k * PERIOD_S, 12.0 + 30 * PERIOD_S) for k in range(30, 35)]
    assert late_s == pytest.approx([10.0 + k * PERIOD_S for k in range(30, 35)])
