from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.safety.guards.target_keep_out import TargetKeepOutGuard
from tests.safety.closed_loop import LIMITS, PARAMETERS, PERIOD_S, Body, context_of, fly, setpoint_of, supervisor_of, target_at

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
    if distance > 1e-3:
        assert (out[0] * n + out[1] * e) / distance <= (wn * n + we * e) / distance + 1e-6
        relative = ((out[0] - tn) * n + (out[1] - te) * e) / distance
        if distance <= PARAMETERS.target_keep_out_m:
            assert relative <= 1e-6 or math.hypot(out[0], out[1]) >= LIMITS.speed_max_m_s - 1e-6
    assert (verdict.reason == "") == (out.tolist() == [wn, we, 0.0])


def test_no_track_no_rule() -> None:
    assert GUARD.check(setpoint_of(5.0, 0.0), context_of(Body("p1", (0, 0)))).reason == ""
