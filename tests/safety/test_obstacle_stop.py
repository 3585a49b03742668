from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import clearance_m
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.sim.multirotor import Command, Multirotor, MultirotorLimits, Wind
from tests.safety.closed_loop import (
    LIMITS,
    PARAMETERS,
    PERIOD_S,
    STEPS_A_PERIOD,
    Body,
    context_of,
    discs_at,
    fly,
    random_wishes,
    setpoint_of,
    supervisor_of,
    target_at,
    towards,
)

GUARD = ObstacleStopGuard(PARAMETERS)
place = st.floats(-6, 6)
speed = st.floats(-6, 6)


def _field(seed: int) -> tuple[np.ndarray, list[float]]:
    rng = np.random.default_rng(seed)
    discs = discs_at(*[(*rng.uniform(-8, 8, 2), rng.uniform(0.3, 1.2)) for _ in range(8)])
    while True:
        start = rng.uniform(-8, 8, 2)
        if clearance_m(start, discs, LIMITS.body_radius_m) > 0.15:
            return discs, start.tolist()


def _least(path: np.ndarray, discs: np.ndarray) -> float:
    return min(clearance_m(point[:2], discs, LIMITS.body_radius_m) for point in path)


def test_nobody_hits_a_known_disc_and_without_the_guard_many_do() -> None:
    hits = 0
    for seed in range(10):
        discs, start = _field(seed)
        aim = discs[seed % 8, :2] + np.random.default_rng(seed).uniform(-0.8, 0.8, 2)
        for wish in (random_wishes(seed), towards(discs[seed % 8, :2]), towards(aim)):
            path, _ = fly(Body("p1", start), wish, supervisor_of(GUARD), 6, lambda t, b, d=discs: context_of(b, t, discs=d))
            assert _least(path, discs) > 0.0
            twin, _ = fly(Body("p1", start), wish, None, 6, lambda t, b, d=discs: context_of(b, t, discs=d))
            hits += _least(twin, discs) < 0.0
    assert hits >= 20


@pytest.mark.parametrize("offset", [0.0, 0.2, 0.5])
def test_a_disc_that_appears_late_is_still_missed_from_three_and_a_half_metres_at_full_speed(offset: float) -> None:
    discs = discs_at((3.5, offset, 0.5))
    body = Body("p1", (0.0, 0.0), (5.0, 0.0, 0.0))
    body.previous = setpoint_of(5.0, 0.0)
    wish = np.array([5.0, 0.0, 0.0])
    path, _ = fly(body, lambda t, b: wish, supervisor_of(GUARD), 3, lambda t, b: context_of(b, t, discs=discs))
    assert _least(path, discs) > 0.0


def test_a_close_and_fast_pass_beside_a_disc_is_left_alone() -> None:
    discs = discs_at((4.0, 1.0 + LIMITS.body_radius_m + 0.15, 1.0))
    body = Body("p1", (0.0, 0.0), (5.0, 0.0, 0.0))
    for north in np.linspace(0, 8, 40):
        body.position[0] = north
        assert GUARD.check(setpoint_of(5.0, 0.0), context_of(body, discs=discs)).reason == ""


def test_flying_at_a_disc_is_stopped_with_a_plain_reason() -> None:
    verdict = GUARD.check(setpoint_of(5.0, 0.0), context_of(Body("p1", (0, 0), (5.0, 0, 0)), discs=discs_at((2.5, 0.0, 0.5))))
    assert verdict.setpoint.velocity_ned_m_s[0] < 3.0
    assert verdict.reason == "obstacle 1.6 m away: too fast towards it, braking hard"
    slowly = GUARD.check(setpoint_of(5.0, 0.0), context_of(Body("p1", (0, 0), (1.0, 0, 0)), discs=discs_at((2.5, 0.0, 0.5))))
    assert "obstacle 1.6 m away: approaching it at no more than" in slowly.reason


def test_an_approaching_disc_stops_but_never_pushes() -> None:
    discs = discs_at((2.0, 0.0, 0.4))
    discs[0, 3] = -4.0
    assert GUARD.check(setpoint_of(0.0, 0.0), context_of(Body("p1", (0, 0)), discs=discs)).reason == ""
    assert GUARD.check(setpoint_of(2.0, 0.0), context_of(Body("p1", (0, 0)), discs=discs)).setpoint.velocity_ned_m_s[0] < 1.2


def test_a_receding_disc_is_trusted_only_where_a_vehicle_is_known() -> None:
    discs = discs_at((2.2, 0.0, 0.3))
    discs[0, 3] = 2.5
    body = Body("p1", (0, 0), (2.5, 0, 0))
    unknown = GUARD.check(setpoint_of(2.5, 0.0), context_of(body, discs=discs))
    known = GUARD.check(setpoint_of(2.5, 0.0), context_of(body, discs=discs, target=target_at((2.3, 0.1, -5), (2.5, 0, 0))))
    assert unknown.reason != ""
    assert known.reason == ""


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(place, place, st.floats(0.05, 2)), max_size=12), speed, speed, speed, speed)
def test_only_who_is_too_fast_is_asked_for_more_than_standing_and_never_for_more_than_its_own_speed(
    rows: list[tuple[float, float, float]], vn: float, ve: float, wn: float, we: float
) -> None:
    context = context_of(Body("p1", (0, 0), (vn, ve, 0)), discs=discs_at(*rows))
    out = GUARD.check(setpoint_of(wn, we, 0.2, 1.0), context).setpoint.velocity_ned_m_s
    bounds = GUARD.bounds((wn, we), 9.0, context)
    assert out[2] == 0.2
    assert math.hypot(out[0], out[1]) <= max(math.hypot(wn, we), LIMITS.speed_max_m_s) + 1e-6
    for bound in bounds:
        closing = bound.north * vn + bound.east * ve
        assert math.hypot(bound.north, bound.east) == pytest.approx(1.0)
        assert bound.bound_m_s >= min(0.0, -closing) - 1e-9
        if bound.bound_m_s < 0.0:
            assert closing > 0.0
    if all(bound.bound_m_s >= 0.0 for bound in bounds):
        assert math.hypot(out[0], out[1]) <= math.hypot(wn, we) + 1e-6
        assert GUARD.check(setpoint_of(0.0, 0.0), context).reason == ""
        for bound in bounds:
            assert bound.excess_m_s((out[0], out[1])) <= 1e-6
    standing = context_of(Body("p1", (0, 0)), discs=discs_at(*rows))
    assert GUARD.check(setpoint_of(0.0, 0.0), standing).reason == ""


def test_the_command_settles_before_a_wall_of_discs_and_slides_past_a_single_one() -> None:
    wish = np.array([5.0, 0.0, 0.0])
    wall = discs_at(*[(8.0, east, 1.0) for east in np.arange(-8.0, 8.1, 1.0)])
    path, sent = fly(Body("p1", (0, 0)), lambda t, b: wish, supervisor_of(GUARD), 16, lambda t, b: context_of(b, t, discs=wall))
    speeds = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1) / (PERIOD_S / STEPS_A_PERIOD)
    assert np.abs(np.diff(speeds)).sum() < 2 * speeds.max() + 0.2
    assert np.abs(np.diff(sent[:, :2], axis=0)).sum() < 2 * 5.0 + 7.0
    assert np.abs(sent[-25:, :2]).max() < 0.1
    one = discs_at((8.0, 0.0, 1.0))
    path, sent = fly(Body("p1", (0, 0)), lambda t, b: wish, supervisor_of(GUARD), 8, lambda t, b: context_of(b, t, discs=one))
    assert _least(path, one) > 0.0
    assert np.abs(np.diff(sent[:, :2], axis=0)).sum() < 16.0


def _clearance_after_a_late_hover_m(*, guarded: bool, gain_1_s: float, wind_east_m_s: float) -> float:
    """A vehicle that swerves round a tree is told to hover 0.6 m before it; least clearance, with an autopilot's velocity loop.

    gain_1_s: acceleration per velocity error; PX4's MPC_XY_VEL_P_ACC is 1.8 by default, and the tilt follows 0.1 s later.
    """
    frame = MultirotorLimits(
        speed_max_m_s=6.5, acceleration_max_m_s2=6.5, jerk_max_m_s3=52.0, response_s=0.1, velocity_gain_1_s=gain_1_s
    )
    tree, start = discs_at((6.0, 0.4, 0.5)), (0.0, 0.0, -5.0)
    vehicle = Multirotor(frame, position_ned_m=start, ground_down_m=0.0, wind=Wind(0.0, wind_east_m_s))
    vehicle.motors.running, vehicle.on_ground = True, False
    supervisor, seen = supervisor_of(GUARD), Body("p1", start)
    least, hovers = math.inf, False
    for step in range(round(5.0 / PERIOD_S)):
        seen.position, seen.velocity = np.array(vehicle.position_ned_m), np.array(vehicle.velocity_ned_m_s)
        least = min(least, clearance_m(seen.position[:2], tree, LIMITS.body_radius_m))
        hovers |= least < 0.6
        away = -1.0 if least < 1.5 else 0.0
        sent = setpoint_of(0.0, 0.0) if hovers else setpoint_of(2.5, away)
        if guarded:
            sent = supervisor.check(sent, context_of(seen, step * PERIOD_S, discs=tree)).setpoint
        seen.previous = sent
        north, east, down = sent.velocity_ned_m_s.tolist()
        for _ in range(8):
            vehicle.step(PERIOD_S / 8, Command(velocity_ned_m_s=(north, east, down), yaw_rad=0.0))
    return least


@pytest.mark.parametrize("gain_1_s", [1.8, 2.2])
@pytest.mark.parametrize("wind_east_m_s", [0.0, 7.0])
def test_a_late_hover_is_braked_harder_than_its_zero_would_and_the_twin_touches_the_tree(
    gain_1_s: float, wind_east_m_s: float
) -> None:
    assert _clearance_after_a_late_hover_m(guarded=True, gain_1_s=gain_1_s, wind_east_m_s=wind_east_m_s) > 0.0
    assert _clearance_after_a_late_hover_m(guarded=False, gain_1_s=gain_1_s, wind_east_m_s=wind_east_m_s) < 0.0
