from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import clearance_m
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from tests.safety.closed_loop import (
    LIMITS,
    PARAMETERS,
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
    assert "obstacle 1.6 m away: approaching it at no more than" in verdict.reason


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
def test_never_faster_and_standing_always_passes(
    rows: list[tuple[float, float, float]], vn: float, ve: float, wn: float, we: float
) -> None:
    context = context_of(Body("p1", (0, 0), (vn, ve, 0)), discs=discs_at(*rows))
    out = GUARD.check(setpoint_of(wn, we, 0.2, 1.0), context).setpoint.velocity_ned_m_s
    assert math.hypot(out[0], out[1]) <= math.hypot(wn, we) + 1e-6
    assert out[2] == 0.2
    assert GUARD.check(setpoint_of(0.0, 0.0), context).reason == ""
    for bound in GUARD.bounds((wn, we), 9.0, context):
        assert bound.excess_m_s((out[0], out[1])) <= 1e-6
        assert math.hypot(bound.north, bound.east) == pytest.approx(1.0)


def test_the_command_settles_before_a_wall_of_discs_and_slides_past_a_single_one() -> None:
    wish = np.array([5.0, 0.0, 0.0])
    wall = discs_at(*[(8.0, east, 1.0) for east in np.arange(-8.0, 8.1, 1.0)])
    path, sent = fly(Body("p1", (0, 0)), lambda t, b: wish, supervisor_of(GUARD), 16, lambda t, b: context_of(b, t, discs=wall))
    assert np.abs(np.diff(sent[:, :2], axis=0)).sum() < 2 * 5.0 + 3.0
    assert np.abs(sent[-25:, :2]).max() < 0.1
    one = discs_at((8.0, 0.0, 1.0))
    path, sent = fly(Body("p1", (0, 0)), lambda t, b: wish, supervisor_of(GUARD), 8, lambda t, b: context_of(b, t, discs=one))
    assert _least(path, one) > 0.0
    assert np.abs(np.diff(sent[:, :2], axis=0)).sum() < 16.0
