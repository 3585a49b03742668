"""The disturbance observer: what it finds, where its poles lie, and what it does when measurements fail."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.control.gains import DEFAULT, Gains
from flightapp.control.observer import APPLIED, DISTURBANCE, GAP, POSITION, STATE_SIZE, VELOCITY, observe
from flightapp.core.types import Array

NOWHERE = np.full(3, math.nan)


def falling(dt_s: float, push: Array, seconds: float, gains: Gains) -> tuple[Array, Array]:
    """The state after `seconds` of watching a vehicle that nothing but `push` moves, and the vehicle's velocity."""
    state, flat = np.zeros(STATE_SIZE), gains.as_array()
    for k in range(round(seconds / dt_s) + 1):
        t_s = k * dt_s
        observe(state, flat, dt_s, 0.5 * push * t_s * t_s, push * t_s)
    return state, push * round(seconds / dt_s) * dt_s


@settings(max_examples=25, deadline=None)
@given(st.floats(0.005, 0.1), st.tuples(*[st.floats(-1.5, 1.5)] * 3), st.booleans())
def test_a_constant_disturbance_is_found_within_twelve_time_constants(
    dt_s: float, push: tuple[float, float, float], by_velocity: bool
) -> None:
    gains = Gains(period_s=dt_s, observes_velocity=float(by_velocity))
    state, _ = falling(dt_s, np.array(push), 12.0 / gains.observer_rad_s + dt_s, gains)
    size = float(np.linalg.norm(push))
    assert np.linalg.norm(state[DISTURBANCE : DISTURBANCE + 3] - push) <= 0.01 * size + 1e-9


@pytest.mark.parametrize("dt_s", [0.005, 0.02, 0.1])
def test_all_poles_of_the_error_lie_at_one_place(dt_s: float) -> None:
    """Column by column: what the observer makes of a unit error in each of its states."""
    gains = Gains(period_s=dt_s, schedule_1_m2=0.0, disturbance_max_m_s2=math.inf)
    columns = []
    for first in (POSITION, VELOCITY, DISTURBANCE):
        state = np.zeros(STATE_SIZE)
        flat = gains.as_array()
        observe(state, flat, dt_s, np.zeros(3), np.zeros(3))
        state[first] = 1.0
        observe(state, flat, dt_s, np.zeros(3), np.zeros(3))
        columns.append(state[[POSITION, VELOCITY, DISTURBANCE]])
    q = math.exp(-gains.observer_rad_s * dt_s)
    characteristic = np.poly(np.array(columns).T)
    assert characteristic == pytest.approx(np.poly([q, q, q]), abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from([0.0, -0.02, 1e-6, 0.02, 0.05, 0.3, 7.0, math.nan]),
            st.sampled_from([0.0, 1.0, -3.0, 60.0, 1e200, math.nan, math.inf]),
        ),
        max_size=30,
    ),
    st.booleans(),
)
def test_whatever_is_measured_the_state_stays_finite(steps: list[tuple[float, float]], by_velocity: bool) -> None:
    state, flat = np.zeros(STATE_SIZE), Gains(observes_velocity=float(by_velocity)).as_array()
    for dt_s, seen in steps:
        observe(state, flat, dt_s, np.full(3, seen), np.full(3, seen))
        assert np.isfinite(state).all()
        assert np.linalg.norm(state[DISTURBANCE : DISTURBANCE + 3]) <= DEFAULT.disturbance_max_m_s2 + 1e-9


def test_in_a_drop_out_it_predicts_forgets_slowly_and_starts_anew_afterwards() -> None:
    push = np.array((1.0, -0.5, 0.2))
    state, velocity = falling(0.02, push, 3.0, DEFAULT)
    flat = DEFAULT.as_array()
    before = state.copy()
    for _ in range(20):
        observe(state, flat, 0.02, NOWHERE, NOWHERE)
    assert state[VELOCITY] == pytest.approx(velocity[0] + 0.4 * push[0], rel=0.05)
    assert state[GAP] == pytest.approx(0.4)
    assert 0.75 < state[DISTURBANCE] / before[DISTURBANCE] < 0.9
    for _ in range(10):
        observe(state, flat, 0.02, NOWHERE, NOWHERE)
    observe(state, flat, 0.02, np.array((500.0, 0.0, 0.0)), np.array((1.0, 2.0, 3.0)))
    assert state[POSITION : POSITION + 3].tolist() == [500.0, 0.0, 0.0]
    assert state[VELOCITY : VELOCITY + 3].tolist() == [1.0, 2.0, 3.0]
    assert 0.0 < state[DISTURBANCE] < before[DISTURBANCE], "what is known of the wind outlives a short gap"
    for _ in range(120):
        observe(state, flat, 0.02, NOWHERE, NOWHERE)
    observe(state, flat, 0.02, np.zeros(3), np.zeros(3))
    assert state[DISTURBANCE] == 0.0, "but not a long one"


def test_a_jump_is_not_believed_at_once() -> None:
    state, flat = np.zeros(STATE_SIZE), DEFAULT.as_array()
    for _ in range(5):
        observe(state, flat, 0.02, np.zeros(3), np.zeros(3))
    observe(state, flat, 0.02, np.array((6.0, 0.0, 0.0)), np.zeros(3))
    assert abs(state[POSITION]) < 1e-9
    observe(state, flat, 0.02, np.array((4.0, 0.0, 0.0)), np.zeros(3))
    assert state[POSITION] > 0.5


def test_a_step_that_is_not_positive_changes_nothing() -> None:
    state, _ = falling(0.02, np.array((1.0, 0.0, 0.0)), 0.5, DEFAULT)
    state[APPLIED] = 3.0
    before = state.copy()
    for dt_s in (0.0, -0.1, math.nan):
        observe(state, DEFAULT.as_array(), dt_s, np.ones(3), np.ones(3))
    assert (state == before).all()


def test_a_long_step_is_predicted_in_parts() -> None:
    """What was applied reaches the vehicle with a lag: one long step of it would be believed to act from its beginning."""
    flat, once, often = DEFAULT.as_array(), np.zeros(STATE_SIZE), np.zeros(STATE_SIZE)
    for state, steps, dt_s in ((once, 1, 0.4), (often, 20, 0.02)):
        observe(state, flat, 0.02, np.zeros(3), np.zeros(3))
        state[APPLIED] = 3.0
        for _ in range(steps):
            observe(state, flat, dt_s, NOWHERE, NOWHERE)
    assert once[VELOCITY] == pytest.approx(often[VELOCITY])
    assert once[POSITION] == pytest.approx(often[POSITION])
    assert once[GAP] == pytest.approx(often[GAP])
