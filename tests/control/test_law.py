"""The law in closed loop, its limit, and what goes first."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.control.gains import DEFAULT
from flightapp.control.law import GRAVITY_M_S2, REFERENCE_SIZE, decide, leaned, limited_sum
from flightapp.control.observer import APPLIED, STATE_SIZE, observe
from tests.control.plant import fly_step

DIRECTION = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: math.hypot(*v) > 0.1)
PERIOD = st.sampled_from([0.02, 0.0, -0.02, 1e-6, 0.3, 7.0, math.nan])
NUMBER = st.sampled_from([0.0, 1.0, -2.5, 40.0, -1e9, 1e200, math.nan, math.inf, -math.inf])


@settings(max_examples=6, deadline=None)
@given(
    DIRECTION,
    st.floats(2.0, 50.0),
    DIRECTION,
    st.floats(0.0, 2.0),
    st.floats(0.05, 0.15),
    st.floats(0.0, 0.04),
    st.sampled_from([0.02, 0.05, 0.1]),
)
def test_a_step_ends_at_its_goal_without_overshoot(
    towards: tuple[float, float, float],
    size_m: float,
    blown: tuple[float, float, float],
    push_m_s2: float,
    lag_s: float,
    delay_s: float,
    dt_s: float,
) -> None:
    """Specification 8.9. What the push alone moves the vehicle before it is known is not overshoot: up to 0.25 m."""
    start = size_m * np.array(towards) / math.hypot(*towards)
    push = push_m_s2 * np.array(blown) / math.hypot(*blown)
    story = fly_step(replace(DEFAULT, period_s=dt_s), start, push, lag_s, delay_s, 22.0)
    assert story.overshoot_share <= 0.05 + 0.125 * push_m_s2 / size_m
    assert story.error_m <= 0.05
    assert story.command_max_m_s2 <= DEFAULT.acceleration_max_m_s2 * (1.0 + 1e-9)


def test_the_observer_winds_up_where_it_is_fed_with_the_raw_command() -> None:
    """The unsafe twin: the same flight, the wrong wire."""
    start, push = np.array((30.0, 0.0, 0.0)), np.array((0.0, 1.0, 0.0))
    assert fly_step(DEFAULT, start, push, 0.1, 0.02, 15.0).excess_m_s2 <= 2.0
    unbounded = replace(DEFAULT, disturbance_max_m_s2=math.inf)
    assert fly_step(unbounded, start, push, 0.1, 0.02, 15.0).excess_m_s2 <= 2.0
    assert fly_step(unbounded, start, push, 0.1, 0.02, 15.0, fed_raw=True).excess_m_s2 > 2.0


@settings(max_examples=60, deadline=None)
@given(st.tuples(*[NUMBER] * 3), st.tuples(*[NUMBER] * 9), st.tuples(*[NUMBER] * 3), st.lists(PERIOD, min_size=1, max_size=4))
def test_every_command_is_finite_and_limited(
    seen: tuple[float, ...], reference: tuple[float, ...], avoidance: tuple[float, ...], periods_s: list[float]
) -> None:
    """Specification 8.12: whatever is measured, asked for, and stamped: duplicated, reordered, late."""
    state, flat, command = np.zeros(STATE_SIZE), DEFAULT.as_array(), np.zeros(3)
    for dt_s in periods_s:
        observe(state, flat, dt_s, np.array(seen), np.array(seen))
        decide(state, flat, np.array(reference), np.array(avoidance), command)
        assert np.isfinite(command).all()
        assert np.linalg.norm(command) <= DEFAULT.acceleration_max_m_s2 * (1.0 + 1e-9)
        assert math.hypot(*command[:2]) <= math.tan(DEFAULT.tilt_max_rad) * (GRAVITY_M_S2 - command[2]) * (1.0 + 1e-9)
        assert (state[APPLIED : APPLIED + 3] == command).all(), "the observer is told what was commanded"


@settings(deadline=None)
@given(st.tuples(*[st.floats(-6.0, 6.0)] * 3), st.tuples(*[st.floats(-50.0, 50.0)] * 3))
def test_tracking_never_takes_from_avoidance(first: tuple[float, ...], second: tuple[float, ...]) -> None:
    out, limit = np.zeros(3), 6.0
    avoidance, tracking = np.array(first), np.array(second)
    limited_sum(avoidance, tracking, out, limit)
    kept = avoidance * min(1.0, limit / max(np.linalg.norm(avoidance), 1e-12))
    added = out - kept
    assert np.linalg.norm(out) <= limit * (1.0 + 1e-9)
    share = float(added @ tracking) / max(float(tracking @ tracking), 1e-12)
    assert -1e-9 <= share <= 1.0 + 1e-9
    assert added == pytest.approx(share * tracking, abs=1e-6)
    if share < 1.0 - 1e-6 and np.linalg.norm(tracking) > 1e-6:
        assert np.linalg.norm(out) == pytest.approx(limit, rel=1e-6), "nothing is left unused"


def test_without_measurements_the_vehicle_brakes() -> None:
    state, flat, command = np.zeros(STATE_SIZE), DEFAULT.as_array(), np.zeros(3)
    reference = np.zeros(REFERENCE_SIZE)
    reference[3] = 5.0
    observe(state, flat, 0.02, np.zeros(3), np.array((5.0, 0.0, 0.0)))
    for _ in range(40):
        observe(state, flat, 0.02, np.full(3, math.nan), np.full(3, math.nan))
        decide(state, flat, reference, np.zeros(3), command)
    assert command[0] < -1.0


def test_a_multirotor_that_falls_leans_less_and_one_that_need_not_lean_is_left_alone() -> None:
    level, sinking = np.array((5.0, 3.0, 0.0)), np.array((5.0, 3.0, 3.0))
    leaned(level, math.radians(35.0))
    assert level.tolist() == [5.0, 3.0, 0.0]
    leaned(sinking, math.radians(35.0))
    assert math.atan2(math.hypot(*sinking[:2]), GRAVITY_M_S2 - sinking[2]) == pytest.approx(math.radians(35.0))
    assert sinking[2] == 3.0
    assert sinking[0] / sinking[1] == pytest.approx(5.0 / 3.0)


@settings(max_examples=5, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.05, 0.15), st.booleans())
def test_an_uneven_period_does_not_unsettle_it(seed: int, lag_s: float, has_gaps: bool) -> None:
    """Specification 4, jitter: half to twice the nominal period; in a gap of ten the vehicle flies the last command on."""
    random = np.random.default_rng(seed)
    periods_s = 0.02 * random.uniform(0.5, 2.0, 900)
    if has_gaps:
        periods_s[random.random(900) < 0.01] = 0.2
    story = fly_step(DEFAULT, np.array((12.0, -5.0, 2.0)), np.array((1.0, 0.5, 0.0)), lag_s, 0.02, 0.0, periods_s=periods_s)
    assert has_gaps or story.overshoot_share <= 0.05
    assert story.error_m <= 0.05
