from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
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
