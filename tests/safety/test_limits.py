from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Setpoint
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.guards.yaw_rate import YawRateGuard
from tests.safety.closed_loop import LIMITS, PARAMETERS, PERIOD_S, Body, context_of, setpoint_of

speed = st.floats(-20, 20)
angle = st.floats(-math.pi, math.pi)


@settings(max_examples=200, deadline=None)
@given(speed, speed, st.one_of(st.none(), st.floats(0.1, 9)))
def test_speed_is_capped_in_its_own_direction(north: float, east: float, mission_max: float | None) -> None:
    verdict = SpeedGuard(mission_max).check(setpoint_of(north, east, 0.5, 0.1), context_of(Body("p1", (0, 0))))
    out = verdict.setpoint.velocity_ned_m_s
    cap = min(LIMITS.speed_max_m_s, mission_max or math.inf)
    assert math.hypot(out[0], out[1]) <= min(cap, math.hypot(north, east)) + 1e-9
    assert abs(out[0] * east - out[1] * north) < 1e-6
    assert out[2] == 0.5


@settings(max_examples=300, deadline=None)
@given(speed, speed, speed, speed)
def test_braking_is_never_put_off_and_everything_else_is_limited(on: float, oe: float, wn: float, we: float) -> None:
    body = Body("p1", (0, 0))
    body.previous = setpoint_of(on, oe)
    out = AccelerationGuard(PARAMETERS).check(setpoint_of(wn, we), context_of(body)).setpoint.velocity_ned_m_s
    old, wish = np.array([on, oe]), np.array([wn, we])
    old_speed = float(np.hypot(*old))
    if old_speed > 0.01:
        along = old / old_speed
        wanted, got = float(wish @ along), float(out[:2] @ along)
        assert got <= max(wanted, 0.0, min(old_speed, max(wanted, 0.0)) + LIMITS.acceleration_max_m_s2 * PERIOD_S) + 1e-6
        if wanted <= 0.0:
            assert got <= 1e-6
        braked = along * min(old_speed, max(0.0, wanted))
        assert np.hypot(*(out[:2] - braked)) <= LIMITS.acceleration_max_m_s2 * PERIOD_S + 1e-6
    assert np.hypot(*(wish - out[:2])) <= np.hypot(*(wish - old)) + 1e-6


def test_acceleration_and_jerk_hold_over_a_step_in_speed() -> None:
    guard, body = AccelerationGuard(PARAMETERS), Body("p1", (0, 0))
    body.previous = setpoint_of(0.0, 0.0)
    speeds = [0.0]
    for _ in range(50):
        body.previous = guard.check(setpoint_of(5.0, 0.0), context_of(body)).setpoint
        speeds.append(float(body.previous.velocity_ned_m_s[0]))
    acceleration = np.diff(speeds) / PERIOD_S
    assert acceleration.max() <= LIMITS.acceleration_max_m_s2 + 1e-9
    assert np.diff(acceleration).max() <= LIMITS.jerk_max_m_s3 * PERIOD_S + 1e-9
    assert acceleration[0] <= LIMITS.jerk_max_m_s3 * PERIOD_S + 1e-9
    assert speeds[-1] == 5.0
    stopped = guard.check(setpoint_of(0.0, 0.0), context_of(body))
    assert not stopped.setpoint.velocity_ned_m_s.any()
    assert stopped.reason == ""


def test_a_late_period_does_not_buy_a_jump_and_the_first_one_starts_from_the_own_velocity() -> None:
    body = Body("p1", (0, 0), (1.0, 0.0, 0.0))
    late = AccelerationGuard(PARAMETERS).check(setpoint_of(5.0, 0.0), context_of(body, dt_s=30.0))
    assert late.setpoint.velocity_ned_m_s[0] <= 1.0 + LIMITS.acceleration_max_m_s2 * 0.2 + 1e-9
    assert "m/s planar" in late.reason


@settings(max_examples=200, deadline=None)
@given(st.floats(-9, 9), st.floats(-9, 9))
def test_vertical_speed_grows_slowly_and_ends_at_once(old: float, wish: float) -> None:
    body = Body("p1", (0, 0))
    body.previous = setpoint_of(0.0, 0.0, old)
    out = AccelerationGuard(PARAMETERS).check(setpoint_of(0.0, 0.0, wish), context_of(body)).setpoint.velocity_ned_m_s[2]
    step = PARAMETERS.vertical_acceleration_m_s2 * PERIOD_S
    assert abs(out) <= max(abs(wish), 1e-9) + 1e-9 or out * wish <= 0.0
    assert abs(out) <= min(abs(old), abs(wish)) + step + 1e-6 or old * wish < 0.0
    if old * wish <= 0.0:
        assert abs(out) <= step + 1e-6
    assert abs(wish - out) <= abs(wish - old) + 1e-9


@settings(max_examples=200, deadline=None)
@given(angle, angle)
def test_yaw_turns_the_short_way_no_faster_than_it_may(old: float, wish: float) -> None:
    body = Body("p1", (0, 0))
    body.previous = setpoint_of(1.0, 0.0, 0.0, old)
    verdict = YawRateGuard().check(setpoint_of(1.0, 2.0, 0.3, wish), context_of(body))
    turned = wrap_pi(verdict.setpoint.yaw_rad - old)
    wanted = wrap_pi(wish - old)
    assert abs(turned) <= LIMITS.yaw_rate_max_rad_s * PERIOD_S + 1e-6
    assert abs(turned) <= abs(wanted) + 1e-6
    assert abs(wrap_pi(wish - verdict.setpoint.yaw_rad)) <= abs(wanted) + 1e-6
    assert verdict.setpoint.velocity_ned_m_s.tolist() == [1.0, 2.0, 0.3]


def _flown(wishes: list[tuple[float, float, float]], hold: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Wishes, each held for some periods, and the setpoints that the guard made of them, each (n, 3)."""
    guard, body = AccelerationGuard(PARAMETERS), Body("p1", (0, 0))
    body.previous = setpoint_of(0.0, 0.0)
    wished, sent = [], []
    for index, wish in enumerate(np.repeat(np.array(wishes), hold, axis=0)):
        body.previous = guard.check(setpoint_of(*wish), context_of(body, index * PERIOD_S)).setpoint
        wished.append(wish)
        sent.append(body.previous.velocity_ned_m_s)
    return np.array(wished), np.array(sent)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-2, 2)), min_size=3, max_size=10))
def test_no_axis_gains_speed_faster_than_acceleration_and_jerk_allow(wishes: list[tuple[float, float, float]]) -> None:
    _, sent = _flown(wishes)
    steps = np.diff(np.vstack((np.zeros((2, 3)), sent)), axis=0) / PERIOD_S
    for index in range(1, len(steps)):
        before, after = sent[index - 2] if index > 1 else np.zeros(3), sent[index - 1]
        for axes, most in ((slice(0, 2), LIMITS.acceleration_max_m_s2), (slice(2, 3), PARAMETERS.vertical_acceleration_m_s2)):
            old, new = before[axes], after[axes]
            speed2 = float(old @ old)
            braked = old * min(1.0, max(0.0, float(old @ new) / speed2)) if speed2 > 1e-6 else old
            gained = (new - braked) / PERIOD_S
            size = float(np.linalg.norm(gained))
            assert size <= most + 0.03
            if size > 1e-6:
                present = max(0.0, float(steps[index - 1][axes] @ gained) / size)
                assert size <= present + LIMITS.jerk_max_m_s3 * PERIOD_S + 0.03  # Braking from below 1 mm/s.


def test_climbing_starts_with_the_jerk_limit_and_without_the_guard_at_once() -> None:
    wished, sent = _flown([(0.0, 0.0, -2.0)], hold=40)
    acceleration = np.diff(np.append(0.0, sent[:, 2])) / PERIOD_S
    assert -acceleration[0] <= LIMITS.jerk_max_m_s3 * PERIOD_S + 1e-9
    assert np.abs(acceleration).max() <= PARAMETERS.vertical_acceleration_m_s2 + 1e-9
    assert sent[-1, 2] == -2.0
    assert abs(wished[0, 2]) / PERIOD_S > PARAMETERS.vertical_acceleration_m_s2


def test_uneven_periods_do_not_buy_jerk() -> None:
    """The acceleration before is that of its own period: a long one followed by short ones gains nothing."""
    guard, body, t_s = AccelerationGuard(PARAMETERS), Body("p1", (0, 0)), 0.0
    body.previous, present = setpoint_of(0.0, 0.0), 0.0
    for dt_s in [0.04, 0.2, 0.01, 0.01, 0.05, 0.01, 0.2, 0.02]:
        t_s += dt_s
        before = float(body.previous.velocity_ned_m_s[0])
        body.previous = guard.check(setpoint_of(5.0, 0.0), context_of(body, t_s, dt_s=dt_s)).setpoint
        acceleration = (float(body.previous.velocity_ned_m_s[0]) - before) / dt_s
        assert acceleration <= min(LIMITS.acceleration_max_m_s2, present + LIMITS.jerk_max_m_s3 * dt_s) + 1e-6
        present = acceleration


def test_after_a_pause_the_own_velocity_counts_and_not_what_was_sent_before_it() -> None:
    guard, body = AccelerationGuard(PARAMETERS), Body("p1", (0, 0))
    body.previous = setpoint_of(5.0, 0.0)
    guard.check(setpoint_of(5.0, 0.0), context_of(body, 0.0))
    after = guard.check(setpoint_of(5.0, 0.0), context_of(body, 20.0)).setpoint
    assert after.velocity_ned_m_s[0] <= LIMITS.jerk_max_m_s3 * PERIOD_S**2 + 1e-9


@pytest.mark.parametrize(("fed", "kept"), [((4.9, 0.0, 1.9), True), ((4.0, 4.0, 0.0), False), ((0.0, 0.0, -2.5), False)])
def test_an_acceleration_beyond_the_limits_is_not_fed_forward(fed: tuple[float, float, float], kept: bool) -> None:
    body = Body("p1", (0, 0))
    body.previous = setpoint_of(1.0, 0.0)
    wish = Setpoint(np.array([1.0, 0.0, 0.0]), 0.0, np.array(fed))
    verdict = AccelerationGuard(PARAMETERS).check(wish, context_of(body))
    assert (verdict.setpoint.acceleration_ned_m_s2 is not None) == kept
    assert (verdict.reason == "") == kept
    assert verdict.setpoint.velocity_ned_m_s.tolist() == [1.0, 0.0, 0.0]


def _turned(wishes: list[float], hold: int) -> np.ndarray:
    """Yaws (n,) that the guard makes of wishes that are held for `hold` periods each, from yaw 0 at rest."""
    guard, body, yaws = YawRateGuard(), Body("p1", (0, 0)), [0.0]
    body.previous = setpoint_of(0.0, 0.0)
    for index, wish in enumerate(np.repeat(wishes, hold)):
        body.previous = guard.check(setpoint_of(0.0, 0.0, 0.0, float(wish)), context_of(body, index * PERIOD_S)).setpoint
        yaws.append(body.previous.yaw_rad)
    return np.unwrap(yaws)


@settings(max_examples=80, deadline=None)
@given(st.lists(angle, min_size=1, max_size=6), st.integers(1, 30))
def test_yaw_rate_and_yaw_acceleration_hold_whatever_is_wished(wishes: list[float], hold: int) -> None:
    rates = np.diff(_turned(wishes, hold)) / PERIOD_S
    assert np.abs(rates).max() <= LIMITS.yaw_rate_max_rad_s + 1e-6
    assert np.abs(np.diff(np.append(0.0, rates))).max() <= LIMITS.yaw_acceleration_max_rad_s2 * PERIOD_S + 1e-6


@settings(max_examples=60, deadline=None)
@given(st.floats(-3.1, 3.1))
def test_a_turn_ends_at_the_wish_without_passing_it(wish: float) -> None:
    yaws = _turned([wish], 50)
    assert yaws[-1] == pytest.approx(wish, abs=1e-6)
    assert (np.abs(yaws) <= abs(wish) + 1e-6).all()
    assert (np.diff(np.abs(yaws)) >= -1e-9).all()
