from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.safety.braking import Braking
from flightapp.safety.velocity_bounds import VelocityBound, project

angles = st.floats(0, 2 * math.pi)
wishes = st.tuples(st.floats(-6, 6), st.floats(-6, 6))


def _bounds(pairs: list[tuple[float, float]]) -> list[VelocityBound]:
    return [VelocityBound(math.cos(a), math.sin(a), b, "g", "thing", 1.0) for a, b in pairs]


@settings(max_examples=300, deadline=None)
@given(wishes, st.lists(st.tuples(angles, st.floats(0, 5)), max_size=12))
def test_feasible_bounds_are_kept_by_the_nearest_velocity(wish: tuple[float, float], pairs: list[tuple[float, float]]) -> None:
    bounds = _bounds(pairs)
    out = project(wish, bounds, 10.0)
    assert all(bound.excess_m_s(out) <= 1e-6 for bound in bounds)
    assert math.hypot(*out) <= math.hypot(*wish) + 1e-6
    grid = [(s * math.cos(a), s * math.sin(a)) for s in np.linspace(0, 6, 13) for a in np.linspace(0, 6.28, 33)]
    inside = [point for point in grid if all(bound.excess_m_s(point) <= 0 for bound in bounds)]
    assert math.dist(out, wish) <= min(math.dist(point, wish) for point in [*inside, (0.0, 0.0)]) + 1e-6


@settings(max_examples=300, deadline=None)
@given(wishes, st.lists(st.tuples(angles, st.floats(-5, 5)), max_size=12))
def test_contradictory_retreats_never_break_the_others(wish: tuple[float, float], pairs: list[tuple[float, float]]) -> None:
    bounds = _bounds(pairs)
    out = project(wish, bounds, 5.0)
    assert all(map(math.isfinite, out))
    assert math.hypot(*out) <= max(5.0, 0.0) + 1e-9
    assert all(bound.excess_m_s(out) <= 1e-6 for bound in bounds if bound.bound_m_s >= 0.0)
    assert all(bound.excess_m_s(out) <= -bound.bound_m_s + 1e-6 for bound in bounds if bound.bound_m_s < 0.0)


def test_a_small_change_of_the_wish_is_a_small_change_of_the_result() -> None:
    bounds = _bounds([(0.1, 1.0), (1.2, 0.5), (2.9, 0.0), (-1.0, 2.0)])
    for angle in np.linspace(0, 6.28, 200):
        first = project((4 * math.cos(angle), 4 * math.sin(angle)), bounds, 5.0)
        second = project((4 * math.cos(angle + 1e-4), 4 * math.sin(angle + 1e-4)), bounds, 5.0)
        assert math.dist(first, second) <= 4e-4 + 1e-9


def test_a_squeezed_vehicle_stops() -> None:
    assert math.hypot(*project((3.0, 1.0), _bounds([(0.0, -1.0), (math.pi, 0.0)]), 5.0)) <= 1.0 + 1e-6
    assert abs(project((3.0, 1.0), _bounds([(0.0, -1.0), (math.pi, 0.0)]), 5.0)[0]) < 1e-6


@settings(max_examples=200, deadline=None)
@given(st.floats(0.5, 8), st.floats(0.05, 1), st.floats(-2, 40))
def test_the_brakeable_speed_can_be_braked(deceleration: float, lag: float, distance: float) -> None:
    braking = Braking(deceleration, lag)
    speed = braking.speed_m_s(distance)
    assert speed >= 0.0
    assert speed * speed / (2 * deceleration) <= max(distance, 0.0) + 1e-9
    assert speed <= max(distance, 0.0) / lag + 1e-9
    assert braking.speed_m_s(distance + 0.01) >= speed
