"""A hunted target's manoeuvres: each does what it says, and none is there unless it is asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.planning.registry import make_evader
from tests.planning.evasion.flight import LIMITS, observation

FAR = 100.0


def course_and_speed(t_s: float, *, pursuer: tuple[float, float] | None = None, **parameters: object) -> tuple[float, float]:
    """Of a target `FAR` north of the boundary, `t_s` after its start."""
    evader = make_evader("manoeuvring", limits=LIMITS, parameters=parameters)
    rows = np.array([(*pursuer, 0.0, 0.0)] if pursuer else []).reshape(-1, 4)
    evader.step(observation(5.0, (FAR, 0.0)))
    n, e, _ = evader.step(observation(5.0 + t_s, (FAR, 0.0), pursuers=rows)).velocity_ned_m_s.tolist()
    return math.atan2(e, n) % (2.0 * math.pi), math.hypot(n, e)


def test_without_a_manoeuvre_it_flies_straight_to_the_boundary_past_any_pursuer() -> None:
    for t_s in (0.1, 5.0, 70.0):
        assert course_and_speed(t_s, pursuer=(FAR - 5.0, 0.0)) == pytest.approx((math.pi, LIMITS.speed_max_m_s), abs=0.01)


def test_it_weaves_to_both_sides_as_far_and_as_fast_as_it_is_told() -> None:
    turns = [course_and_speed(t_s, weave_deg=30.0, weave_period_s=20.0)[0] - math.pi for t_s in (0.0, 5.0, 10.0, 15.0)]
    assert turns == pytest.approx([0.0, math.radians(30.0), 0.0, -math.radians(30.0)], abs=0.02)


def test_it_flees_only_from_who_is_near_enough() -> None:
    near, _ = course_and_speed(1.0, pursuer=(FAR, -6.0), flee_within_m=8.0)
    assert near == pytest.approx(0.5 * math.pi, abs=0.02)
    far, _ = course_and_speed(1.0, pursuer=(FAR, -9.0), flee_within_m=8.0)
    assert far == pytest.approx(math.pi, abs=0.02)


def test_its_speed_jumps_at_the_time_after_its_start() -> None:
    assert course_and_speed(59.0, speed_before_m_s=1.5)[1] == pytest.approx(1.5, abs=0.01)
    assert course_and_speed(61.0, speed_before_m_s=1.5)[1] == pytest.approx(LIMITS.speed_max_m_s, abs=0.01)


def test_a_weave_beyond_sideways_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="weave_deg"):
        make_evader("manoeuvring", limits=LIMITS, parameters={"weave_deg": 120.0})
