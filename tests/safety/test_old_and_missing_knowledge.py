from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import clearance_m
from flightapp.core.types import Setpoint
from flightapp.safety.api import SafetyContext
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.geofence import GeofenceGuard
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.safety.guards.obstacles_age import ObstaclesAgeGuard
from flightapp.safety.guards.own_state_age import OwnStateAgeGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.guards.target_age import TargetAgeGuard
from flightapp.safety.guards.target_keep_out import TargetKeepOutGuard
from flightapp.safety.guards.team_link import TeamLinkGuard
from flightapp.safety.guards.unseen_sector import UnseenSectorGuard
from flightapp.safety.supervisor import Supervisor
from tests.safety.closed_loop import (
    LIMITS,
    PARAMETERS,
    PERIOD_S,
    Body,
    context_of,
    discs_at,
    fly,
    setpoint_of,
    supervisor_of,
    target_at,
)

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


def _frozen(body: Body, guarded: bool) -> Body:
    """Flown for 8 s at 5 m/s by a state that stays at the start, inside a fence of 10 m."""
    fence = GeofenceGuard(((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)), PARAMETERS)
    supervisor = Supervisor(
        stops=(FiniteGuard(), OwnStateAgeGuard(PARAMETERS)) if guarded else (FiniteGuard(),),
        limits=(SpeedGuard(),),
        spatial=(fence,),
        rates=(AccelerationGuard(PARAMETERS),),
        finals=(),
    )
    start = context_of(Body("p1", (0, 0)))
    for step in range(200):
        t_s = step * PERIOD_S
        context = dataclasses.replace(start, t_s=t_s, own_age_s=t_s, previous=body.previous)
        body.fly(supervisor.check(setpoint_of(5.0, 0.0), context).setpoint)
    return body


def test_a_frozen_own_state_ends_within_a_metre_and_its_twin_flies_through_the_fence() -> None:
    assert _frozen(Body("p1", (0, 0)), guarded=True).position[0] < 3.0
    assert _frozen(Body("p1", (0, 0)), guarded=False).position[0] > 10.0


def _camera_stops(guarded: bool) -> float:
    """Clearance to a wall of discs 8 m ahead, when the last picture was taken before it came into view."""
    body, wall = Body("p1", (0, 0)), discs_at((8.0, 0.0, 1.0))
    supervisor = Supervisor(
        stops=(FiniteGuard(),),
        limits=(SpeedGuard(), ObstaclesAgeGuard(PARAMETERS)) if guarded else (SpeedGuard(),),
        spatial=(ObstacleStopGuard(PARAMETERS),),
        rates=(AccelerationGuard(PARAMETERS),),
        finals=(),
    )
    path, _ = fly(body, lambda t, b: np.array([5.0, 0.0, 0.0]), supervisor, 5, lambda t, b: context_of(b, t, obstacles_age_s=t))
    return min(clearance_m(point[:2], wall, LIMITS.body_radius_m) for point in path)


def test_a_camera_that_stops_ends_the_flight_before_its_range_and_its_twin_hits_what_it_did_not_see() -> None:
    assert _camera_stops(guarded=True) > 0.0
    assert _camera_stops(guarded=False) < 0.0


def _unmeasured_evader(guarded: bool, slower_m_s: float = 1.5) -> float:
    """Smallest distance to an evader that fled at 4 m/s when it was measured last and is slower from then on, for 3 s."""
    body = Body("p1", (0.0, 0.0), (4.0, 0.0, 0.0))
    body.previous = setpoint_of(4.0, 0.0)
    guards = (TargetKeepOutGuard(PARAMETERS), TargetAgeGuard(PARAMETERS)) if guarded else (TargetKeepOutGuard(PARAMETERS),)
    least = math.inf

    def situation(t_s: float, pursuer: Body) -> SafetyContext:
        nonlocal least
        least = min(least, abs(6.0 + (4.0 - slower_m_s) * t_s - pursuer.position[0]))
        return context_of(pursuer, t_s, target=target_at((6.0 + 4.0 * t_s, 0.0, -5.0), (4.0, 0.0, 0.0), t_s))

    fly(body, lambda t, b: np.array([5.0, 0.0, 0.0]), supervisor_of(*guards), 3, situation)
    return least


def test_an_evader_not_measured_is_not_believed_to_flee_and_without_the_guard_it_is_run_into() -> None:
    assert _unmeasured_evader(guarded=True) >= PARAMETERS.target_keep_out_m
    assert _unmeasured_evader(guarded=False) < PARAMETERS.target_keep_out_m


@settings(max_examples=150, deadline=None)
@given(*[st.floats(-6, 6)] * 6, st.one_of(st.floats(1.01, 30), st.just(math.inf), st.just(math.nan)))
def test_towards_an_old_track_nothing_is_added_for_its_flight(
    n: float, e: float, vn: float, ve: float, wn: float, we: float, age_s: float
) -> None:
    guard = TargetAgeGuard(PARAMETERS)
    context = context_of(Body("p1", (0, 0), (vn, ve, 0)), target=target_at((n, e, -5), (5.0, 5.0, 0), age_s))
    out = guard.check(setpoint_of(wn, we, 0.1), context).setpoint.velocity_ned_m_s
    distance = math.hypot(n, e)
    if 1e-3 < distance <= PARAMETERS.target_keep_out_m:
        assert (out[0] * n + out[1] * e) / distance <= 1e-6
    assert math.hypot(out[0], out[1]) <= math.hypot(wn, we) + 1e-6
    assert guard.check(setpoint_of(0.0, 0.0), context).reason == ""
    fresh = dataclasses.replace(context, target=target_at((n, e, -5), (5.0, 5.0, 0), 0.9))
    assert guard.check(setpoint_of(wn, we), fresh).reason == ""


@pytest.mark.parametrize(("age_s", "speed"), [(None, 4.0), (0.1, 4.0), (3.0, 4.0), (3.1, 2.5), (math.inf, 2.5), (math.nan, 2.5)])
def test_a_vehicle_that_hears_nobody_slows_down(age_s: float | None, speed: float) -> None:
    context = dataclasses.replace(context_of(Body("p1", (0, 0))), team_link_age_s=age_s)
    verdict = TeamLinkGuard(PARAMETERS).check(setpoint_of(0.0, 4.0, 0.5), context)
    assert verdict.setpoint.velocity_ned_m_s.tolist() == pytest.approx([0.0, speed, 0.5])
    assert (verdict.reason == "") == (speed == 4.0)
    assert TeamLinkGuard(PARAMETERS).check(setpoint_of(2.0, 1.0), context).reason == ""


def _silent_teammate(guarded: bool) -> float:
    """Clearance to a silent teammate that hovers ahead, which the camera first sees at 2 m in the dusk."""
    body, silent = Body("p1", (0.0, 0.0)), discs_at((12.0, 0.0, LIMITS.body_radius_m))
    supervisor = Supervisor(
        stops=(FiniteGuard(),),
        limits=(SpeedGuard(), TeamLinkGuard(PARAMETERS)) if guarded else (SpeedGuard(),),
        spatial=(ObstacleStopGuard(PARAMETERS),),
        rates=(AccelerationGuard(PARAMETERS),),
        finals=(),
    )

    def situation(t_s: float, pursuer: Body) -> SafetyContext:
        seen = 12.0 - pursuer.position[0] < 2.0 + LIMITS.body_radius_m
        return dataclasses.replace(context_of(pursuer, t_s, discs=silent if seen else None), team_link_age_s=4.0 + t_s)

    path, _ = fly(body, lambda t, b: np.array([5.0, 0.0, 0.0]), supervisor, 6, situation)
    return min(clearance_m(point[:2], silent, LIMITS.body_radius_m) for point in path)


def test_a_silent_teammate_seen_late_is_not_hit_and_without_the_guard_it_is() -> None:
    assert _silent_teammate(guarded=True) > 0.0
    assert _silent_teammate(guarded=False) < 0.0
