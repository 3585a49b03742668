from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.safety.guards.target_keep_out import TargetKeepOutGuard
from tests.safety.closed_loop import (
    LIMITS,
    PARAMETERS,
    PERIOD_S,
    STEPS_A_PERIOD,
    Body,
    context_of,
    fly,
    setpoint_of,
    supervisor_of,
    target_at,
)

GUARD = TargetKeepOutGuard(PARAMETERS)
place = st.floats(-8, 8)
speed = st.floats(-5, 5)


def _chase(guarded: bool, evader_velocity: tuple[float, float], seed: int) -> float:
    rng = np.random.default_rng(seed)
    body = Body("p1", rng.uniform(2, 6) * np.array([math.cos(seed), math.sin(seed)]))
    velocity = np.array([*evader_velocity, 0.0])

    def evader(t_s: float) -> np.ndarray:
        return velocity * t_s + np.array([0.0, 0.0, -5.0])

    def wish(t_s: float, pursuer: Body) -> np.ndarray:
        offset = evader(t_s) - pursuer.position
        return offset * (8.0 / max(float(np.hypot(offset[0], offset[1])), 1e-3)) * np.array([1.0, 1.0, 0.0])

    path, _ = fly(
        body,
        wish,
        supervisor_of(GUARD) if guarded else None,
        6,
        lambda t, b: context_of(b, t, target=target_at(evader(t), velocity)),
    )
    times = np.arange(len(path)) * PERIOD_S / 4
    return min(float(np.hypot(*(p - evader(t))[:2])) for p, t in zip(path, times, strict=True))


def test_ramming_is_prevented_and_without_the_guard_it_happens() -> None:
    for seed, velocity in enumerate([(0.0, 0.0), (2.0, 1.0), (-2.5, 0.5), (0.0, -2.0)]):
        assert _chase(True, velocity, seed) >= PARAMETERS.target_keep_out_m - 0.02
        assert _chase(False, velocity, seed) < PARAMETERS.target_keep_out_m


def nearest_of_who_flies_in_m(
    speed_m_s: float, from_m: float, *, guarded: bool, follows: bool = False, chases_m_s: float = 0.0, aside_m: float = 0.0
) -> float:
    """Smallest distance from an evader that flies at a standing pursuer, straight on or following it.

    chases_m_s: what the pursuer's planner wants meanwhile, towards the evader. The track is 0.1 s old, with 5 cm of noise.
    """
    rng = np.random.default_rng(1)
    body, supervisor = Body("p1", (0, 0)), supervisor_of(GUARD)
    evader, velocity, least = np.array([from_m, aside_m, -5.0]), np.array([-speed_m_s, 0.0, 0.0]), math.inf
    measured, measured_velocity = evader, velocity
    for step in range(round(6.0 / PERIOD_S)):
        offset = (evader - body.position) * np.array([1.0, 1.0, 0.0])
        velocity = -offset * (speed_m_s / max(float(np.linalg.norm(offset)), 1e-6)) if follows else velocity
        age_s = PERIOD_S * (step % 4)
        if age_s == 0.0:
            measured, measured_velocity = evader + np.array([*rng.normal(0.0, 0.05, 2), 0.0]), velocity
        track = target_at((measured + age_s * measured_velocity).tolist(), measured_velocity.tolist(), age_s)
        wish = setpoint_of(*(offset * (chases_m_s / max(float(np.linalg.norm(offset)), 1e-6)))[:2].tolist())
        context = context_of(body, step * PERIOD_S, target=track)
        for place in body.fly(supervisor.check(wish, context).setpoint if guarded else wish):
            evader = evader + velocity * (PERIOD_S / STEPS_A_PERIOD)
            least = min(least, math.dist(place[:2], evader[:2]))
    return least


@pytest.mark.parametrize("follows", [False, True], ids=["straight on", "follows"])
@pytest.mark.parametrize("chases_m_s", [0.0, 5.0])
@pytest.mark.parametrize(("speed_m_s", "from_m"), [(2.5, 2.2), (2.5, 4.0), (2.5, 10.0), (5.0, 4.2), (5.0, 6.0), (5.0, 15.0)])
def test_an_evader_that_flies_in_is_retreated_from_in_time_and_reaches_the_twin(
    speed_m_s: float, from_m: float, chases_m_s: float, follows: bool
) -> None:
    kept = nearest_of_who_flies_in_m(speed_m_s, from_m, guarded=True, follows=follows, chases_m_s=chases_m_s)
    assert kept >= PARAMETERS.target_keep_out_m - 0.05
    assert nearest_of_who_flies_in_m(speed_m_s, from_m, guarded=False, follows=follows, chases_m_s=chases_m_s) < 0.1


@pytest.mark.parametrize("aside_m", [0.0, 0.4, -0.4])
def test_who_comes_too_fast_to_be_held_off_is_let_past_without_a_touch_and_hits_the_twin(aside_m: float) -> None:
    needed_m = 5.0**2 / (2 * LIMITS.acceleration_max_m_s2)
    from_m = PARAMETERS.target_keep_out_m + 0.7 * needed_m
    assert nearest_of_who_flies_in_m(5.0, from_m, guarded=True, aside_m=aside_m) > 2 * LIMITS.body_radius_m
    assert nearest_of_who_flies_in_m(5.0, from_m, guarded=False, aside_m=aside_m) < 2 * LIMITS.body_radius_m


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_path_is_left_to_the_side_on_which_the_vehicle_is(side: float) -> None:
    context = context_of(Body("p1", (0, 0)), target=target_at((2.5, 0.3 * side, -5), (-5.0, 0, 0)))
    verdict = GUARD.check(setpoint_of(0.0, 0.0), context)
    assert "leaving its path" in verdict.reason
    assert verdict.setpoint.velocity_ned_m_s[1] * side < -1.0
    assert verdict.setpoint.velocity_ned_m_s[0] < -1.0


def test_who_passes_wide_enough_is_not_sidestepped() -> None:
    context = context_of(Body("p1", (0, 0)), target=target_at((1.2, 1.3, -5), (-5.0, 0, 0)))
    assert "leaving its path" not in GUARD.check(setpoint_of(0.0, 0.0), context).reason


def test_holding_at_the_capture_radius_is_not_disturbed() -> None:
    context = context_of(Body("p1", (0, 0)), target=target_at((2.2, 0, -5), (0.3, 0.2, 0), 0.05))
    for north in (-0.8, 0.0, 0.8):
        assert GUARD.check(setpoint_of(north, 0.5), context).reason == ""


def test_a_fleeing_evader_may_be_followed_at_its_speed() -> None:
    context = context_of(Body("p1", (0, 0), (4.0, 0, 0)), target=target_at((2.2, 0, -5), (4.0, 0, 0)))
    assert GUARD.check(setpoint_of(4.0, 0.0), context).reason == ""


@settings(max_examples=200, deadline=None)
@given(place, place, speed, speed, speed, speed, speed, speed, st.floats(0, 5))
def test_never_closes_faster(
    n: float, e: float, tn: float, te: float, vn: float, ve: float, wn: float, we: float, age_s: float
) -> None:
    context = context_of(Body("p1", (0, 0), (vn, ve, 0.0)), target=target_at((n, e, -5), (tn, te, 0), age_s))
    verdict = GUARD.check(setpoint_of(wn, we), context)
    out = verdict.setpoint.velocity_ned_m_s
    distance = math.hypot(n, e)
    if distance > 1e-3 and "leaving its path" in verdict.reason:
        assert out[0] * n + out[1] * e <= 1e-6 * distance + max(0.0, wn * n + we * e)
    elif distance > 1e-3:
        assert (out[0] * n + out[1] * e) / distance <= (wn * n + we * e) / distance + 1e-6
        relative = ((out[0] - tn) * n + (out[1] - te) * e) / distance
        if distance <= PARAMETERS.target_keep_out_m:
            assert relative <= 1e-6 or math.hypot(out[0], out[1]) >= LIMITS.speed_max_m_s - 1e-6
    assert (verdict.reason == "") == (out.tolist() == [wn, we, 0.0])


def test_no_track_no_rule() -> None:
    assert GUARD.check(setpoint_of(5.0, 0.0), context_of(Body("p1", (0, 0)))).reason == ""
