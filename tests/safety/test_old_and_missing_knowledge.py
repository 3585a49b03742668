from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Setpoint
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.obstacles_age import ObstaclesAgeGuard
from flightapp.safety.guards.own_state_age import OwnStateAgeGuard
from flightapp.safety.guards.unseen_sector import UnseenSectorGuard
from tests.safety.closed_loop import PARAMETERS, Body, context_of, setpoint_of

anything = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=200, deadline=None)
@given(anything, anything, anything, anything)
def test_what_is_not_finite_becomes_zero_velocity_with_yaw_held(n: float, e: float, d: float, yaw: float) -> None:
    body = Body("p1", (0, 0))
    body.previous = setpoint_of(1.0, 1.0, 0.0, 0.7)
    verdict = FiniteGuard().check(Setpoint(np.array([n, e, d]), yaw), context_of(body))
    if all(map(math.isfinite, (n, e, d, yaw))):
        assert verdict.reason == ""
    else:
        assert verdict.reason == "planner gave a setpoint that is not finite"
        assert verdict.setpoint.velocity_ned_m_s.tolist() == [0.0, 0.0, 0.0]
        assert verdict.setpoint.yaw_rad == 0.7


def test_an_own_state_that_is_not_finite_stops_the_vehicle() -> None:
    verdict = FiniteGuard().check(setpoint_of(1.0, 0.0), context_of(Body("p1", (math.nan, 0))))
    assert not verdict.setpoint.velocity_ned_m_s.any()
    assert verdict.reason == "own state is not finite"


def test_an_acceleration_that_is_not_finite_is_dropped() -> None:
    setpoint = Setpoint(np.array([1.0, 0, 0]), 0.0, np.array([math.nan, 0, 0]))
    out = FiniteGuard().check(setpoint, context_of(Body("p1", (0, 0)))).setpoint
    assert out.acceleration_ned_m_s2 is None
    assert out.velocity_ned_m_s[0] == 1.0


@pytest.mark.parametrize(("age_s", "stands"), [(0.0, False), (0.3, False), (0.31, True), (math.inf, True), (math.nan, True)])
def test_an_old_own_state_stops_the_vehicle(age_s: float, stands: bool) -> None:
    verdict = OwnStateAgeGuard(PARAMETERS).check(setpoint_of(2.0, 0.0, 1.0), context_of(Body("p1", (0, 0)), own_age_s=age_s))
    assert verdict.setpoint.velocity_ned_m_s.any() != stands
    assert (verdict.reason != "") == stands


@pytest.mark.parametrize(("age_s", "speed"), [(0.5, 4.0), (0.6, 1.5), (1.5, 1.5), (1.6, 0.0), (math.inf, 0.0), (math.nan, 0.0)])
def test_old_obstacles_slow_the_vehicle_and_then_stop_it(age_s: float, speed: float) -> None:
    context = context_of(Body("p1", (0, 0)), obstacles_age_s=age_s)
    verdict = ObstaclesAgeGuard(PARAMETERS).check(setpoint_of(0.0, 4.0, 0.5), context)
    assert verdict.setpoint.velocity_ned_m_s.tolist() == pytest.approx([0.0, speed, 0.5])
    assert (verdict.reason == "") == (speed == 4.0)


@settings(max_examples=200, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(0, 6), st.floats(0, 2 * math.pi))
def test_speed_into_an_unseen_sector_is_limited(begin: float, end: float, speed: float, bearing: float) -> None:
    wish = setpoint_of(speed * math.cos(bearing), speed * math.sin(bearing), 0.4)
    verdict = UnseenSectorGuard(PARAMETERS).check(wish, context_of(Body("p1", (0, 0)), unseen=np.array([[begin, end]])))
    out = verdict.setpoint.velocity_ned_m_s
    middle, half = begin + 0.5 * ((end - begin) % (2 * math.pi)), 0.5 * ((end - begin) % (2 * math.pi))
    off = abs(math.remainder(bearing - middle, 2 * math.pi))
    if off < half - 1e-6:
        assert math.hypot(out[0], out[1]) <= PARAMETERS.unseen_speed_m_s + 1e-9
    elif off > half + 1e-6:
        assert verdict.reason == ""
    assert math.hypot(out[0], out[1]) <= speed + 1e-9
    assert out[2] == 0.4


def test_seeing_nothing_at_all_limits_every_direction() -> None:
    unseen = np.array([[-math.pi, math.pi]])
    for bearing in np.linspace(0, 6.28, 16):
        wish = setpoint_of(4 * math.cos(bearing), 4 * math.sin(bearing))
        out = UnseenSectorGuard(PARAMETERS).check(wish, context_of(Body("p1", (0, 0)), unseen=unseen)).setpoint.velocity_ned_m_s
        assert math.hypot(out[0], out[1]) == pytest.approx(PARAMETERS.unseen_speed_m_s)
