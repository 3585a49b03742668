"""Rates of arrivals, gaps between setpoints, and two autopilots told apart by their clocks."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.vehicle.gap_meter import GapMeter
from flightapp.vehicle.rate_meter import WINDOW_S, RateMeter
from flightapp.vehicle.twin_watch import DIFFERENT_S, TwinWatch
from flightapp.vehicle.twin_watch import WINDOW_S as TWIN_WINDOW_S


@given(st.floats(1.0, 200.0), st.floats(0.0, 1e6))
def test_a_steady_rate_is_measured(rate_hz: float, start_s: float) -> None:
    meter = RateMeter()
    last_s = start_s
    for number in range(int(4.0 * rate_hz) + 2):
        last_s = start_s + number / rate_hz
        meter.note(last_s)
    assert meter.rate_hz(last_s) == pytest.approx(rate_hz, rel=0.01)


def test_a_link_that_falls_silent_has_no_rate_soon() -> None:
    meter = RateMeter()
    for number in range(100):
        meter.note(number * 0.02)
    assert meter.rate_hz(1.98) == pytest.approx(50.0, rel=0.01)
    assert meter.rate_hz(2.98) < 30.0
    assert meter.rate_hz(1.98 + WINDOW_S) == 0.0


def test_the_longest_wait_counts_also_while_it_lasts() -> None:
    meter = RateMeter()
    assert meter.gap_max_s(5.0) == WINDOW_S
    for number in range(50):
        meter.note(number * 0.02 + (0.3 if number >= 25 else 0.0))
    assert meter.gap_max_s(1.28) == pytest.approx(0.32)
    assert meter.gap_max_s(2.08) == pytest.approx(0.8)


def test_gaps_are_those_inside_a_stream_and_are_counted_once() -> None:
    meter = GapMeter()
    assert meter.take() is None
    for sent_s in (10.0, 10.02, 10.04, 10.14):
        meter.note(sent_s)
    meter.pause()
    for sent_s in (60.0, 60.02):
        meter.note(sent_s)
    gaps = meter.take()
    assert gaps is not None
    assert gaps.p50_ms == pytest.approx(20.0, abs=1e-6)
    assert gaps.max_ms == pytest.approx(100.0, abs=1e-6)
    assert gaps.p50_ms <= gaps.p99_ms <= gaps.max_ms
    assert meter.take() is None


def test_a_gap_over_the_end_of_a_sample_belongs_to_the_next_one() -> None:
    meter = GapMeter()
    meter.note(1.0)
    meter.note(1.02)
    meter.take()
    meter.note(1.5)
    gaps = meter.take()
    assert gaps is not None
    assert gaps.max_ms == pytest.approx(480.0, abs=1e-6)


@given(st.floats(0.0, 1e6), st.lists(st.floats(0.0, 0.9 * DIFFERENT_S), min_size=20, max_size=200))
def test_one_autopilot_on_a_slow_link_is_no_twin(offset_s: float, delays_s: list[float]) -> None:
    watch = TwinWatch()
    for number, delay_s in enumerate(delays_s):
        boot_s = number * 0.02
        watch.note(boot_s, boot_s + offset_s + delay_s)
        assert watch.sign(boot_s + offset_s + delay_s) == ""


@given(st.floats(2.0 * DIFFERENT_S, 1e5), st.lists(st.booleans(), min_size=40, max_size=200))
def test_two_autopilots_are_noticed_however_their_messages_mix(apart_s: float, whose: list[bool]) -> None:
    watch = TwinWatch()
    mixed = [False, True, False, True, False, *whose]
    for number, second in enumerate(mixed):
        now_s = 1e5 + number * 0.02
        watch.note(now_s - (apart_s if second else 0.0), now_s)
    assert "two autopilots" in watch.sign(1e5 + 5 * 0.02)


@given(st.integers(1, 3), st.floats(2.0, 60.0))
def test_a_restart_is_no_twin(restarts: int, ran_s: float) -> None:
    watch, now_s = TwinWatch(), 1000.0
    for _ in range(restarts + 1):
        for number in range(50):
            watch.note(number * 0.02, now_s + number * 0.02)
            assert watch.sign(now_s + number * 0.02) == ""
        now_s += ran_s


def test_a_twin_that_has_left_is_forgotten() -> None:
    watch = TwinWatch()
    for number in range(10):
        now_s = 100.0 + number * 0.02
        watch.note(now_s - (50.0 if number % 2 else 0.0), now_s)
    assert watch.sign(100.2)
    assert watch.sign(100.2 + TWIN_WINDOW_S) == ""
