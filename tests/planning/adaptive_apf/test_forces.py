"""Properties of the single forces (section 8 of the specification)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array, Limits
from flightapp.planning.adaptive_apf.field import (
    COURSE,
    FIELD_SIZE,
    FORCE,
    GAIN,
    REACH_OUT,
    TRACK_COLUMNS,
    braking_m_s2,
    passing_side,
    return_force,
    sum_forces,
)
from flightapp.planning.adaptive_apf.forces import activation_m, closest_approach, repulsion, repulsive_potential
from flightapp.planning.adaptive_apf.fuzzy import ANGLES_DEG, DISTANCES_M, speed_gain
from flightapp.planning.adaptive_apf.gains import Gains
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.planning.adaptive_apf.setpoint import BARRIER, filter_velocity, limit_change, limit_turn
from flightapp.space.distance import nearest_bodies, signed_distance_and_gradient
from flightapp.space.shapes import Cylinder, OrientedBox, Shape, Sphere, bodies_of

FEW = settings(max_examples=25, deadline=None)
LIMITS = Limits(6.0, 6.0, 30.0, 3.0, 12.0, 3.0, 0.25, 0.25)
number = st.floats(-6.0, 6.0)
vector = st.tuples(number, number, number).map(np.array)


def gains(**changed: object) -> Gains:
    return AdaptiveApfParameters.model_validate(changed).gains(LIMITS)


def forces(shapes: list[Shape], place: Array, velocity: Array, goal: Array, given_gains: Gains) -> Array:
    """The field's result around (3,) `place`, with nothing remembered."""
    bodies = bodies_of(shapes)
    which, gaps, out = np.zeros(32, dtype=np.int64), np.zeros((32, 4)), np.zeros(FIELD_SIZE)
    count = nearest_bodies(bodies, *place.tolist(), 0.0, math.inf, which, gaps)
    tracks = np.zeros((len(bodies), TRACK_COLUMNS))
    sum_forces(bodies, which, gaps, count, place, velocity, np.zeros(3), goal, tracks, given_gains, 0.0, 0.1, out)
    return out


@FEW
@given(vector, vector, st.sampled_from(["sphere", "cylinder", "box"]), st.booleans())
def test_repulsion_is_minus_the_gradient_of_its_potential(place: Array, goal: Array, shape: str, is_literal: bool) -> None:
    body: Shape = Sphere(0.3, -0.2, 0.1, 1.0)
    if shape == "cylinder":
        body = Cylinder(0.3, -0.2, 1.0, -2.0, 1.5)
    elif shape == "box":
        body = OrientedBox(0.3, -0.2, 3.0, 1.0, -2.0, 1.5, 0.7)
    bodies = bodies_of([body])
    used = gains()._replace(goal_bounded=0.0 if is_literal else 1.0, force_max_m_s2=math.inf)

    def potential(at: Array) -> float:
        gap = signed_distance_and_gradient(bodies, *at.tolist(), 0.0)[0]
        return repulsive_potential(gap, float(np.linalg.norm(goal - at)), 4.0, used)

    gap, *away = signed_distance_and_gradient(bodies, *place.tolist(), 0.0)
    if not 0.2 < gap < 3.9:
        return
    step = 1e-5
    expected = [-(potential(place + step * axis) - potential(place - step * axis)) / (2.0 * step) for axis in np.eye(3)]
    found = repulsion(gap, *away, *(goal - place).tolist(), 4.0, used)
    np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-5)


@FEW
@given(st.floats(-1.0, 8.0), vector, st.floats(0.5, 6.0))
def test_repulsion_ends_at_its_reach_and_pushes_outwards_before(gap: float, goal: Array, reach: float) -> None:
    out = np.array(repulsion(gap, 1.0, 0.0, 0.0, *goal.tolist(), reach, gains(modules="")))
    assert np.isfinite(out).all()
    assert (out[0] > 0.0) == (gap < reach)
    near = np.array(repulsion(reach - 1e-7, 1.0, 0.0, 0.0, *goal.tolist(), reach, gains()))
    assert np.abs(near).max() < 1e-4


@FEW
@given(vector, vector)
def test_no_force_is_left_at_the_goal(goal: Array, beside: Array) -> None:
    size = float(np.linalg.norm(beside))
    if size < 1.5:
        return
    shapes: list[Shape] = [Sphere(*(goal + beside).tolist(), 1.0), Sphere(*(goal - 0.9 * beside).tolist(), 1.0)]
    with_a = forces(shapes, goal, np.zeros(3), goal, gains(modules="A"))
    assert np.abs(with_a[FORCE : FORCE + 3]).max() < 1e-9
    if size < 3.0:
        assert np.abs(forces(shapes[:1], goal, np.zeros(3), goal, gains(modules=""))[FORCE : FORCE + 3]).max() > 1e-3


@FEW
@given(vector, vector, vector, vector, st.floats(0.0, 2.0 * math.pi), vector)
def test_the_field_turns_and_moves_with_the_scene(
    place: Array, velocity: Array, goal: Array, centre: Array, turn: float, moved: Array
) -> None:
    cos, sin = math.cos(turn), math.sin(turn)
    turned = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    body = np.array((1.0, -0.5, 0.2))
    here: list[Shape] = [Sphere(*centre.tolist(), 1.0, tuple(body))]
    there: list[Shape] = [Sphere(*(turned @ centre + moved).tolist(), 1.0, tuple(turned @ body))]
    one = forces(here, place, velocity, goal, gains())
    two = forces(there, turned @ place + moved, turned @ velocity, turned @ goal + moved, gains())
    assert np.isfinite(one).all()
    if one[7] > 0.05 and math.hypot(*(velocity - body)[:2]) > 0.01:  # inside, and straight above, directions are arbitrary
        np.testing.assert_allclose(two[:3], turned @ one[:3], rtol=1e-6, atol=1e-6)


@FEW
@given(vector, vector)
def test_closest_approach_is_the_least_distance(line_of_sight: Array, relative: Array) -> None:
    t_s, *rest = closest_approach(*line_of_sight.tolist(), *relative.tolist())
    miss, size = np.array(rest[:3]), rest[3]
    assert size == pytest.approx(float(np.linalg.norm(miss)))
    times = np.linspace(0.0, 2.0 * t_s + 1.0, 400)
    distances = np.linalg.norm(line_of_sight - relative * times[:, None], axis=1)
    assert size <= distances.min() + 1e-9
    if t_s > 0.01 and size > 0.06:
        side = np.array(passing_side(*miss.tolist(), size, relative[0], relative[1], 1.0))
        assert abs(side @ relative) < 1e-6 * max(1.0, float(np.linalg.norm(relative)))
        assert closest_approach(*line_of_sight.tolist(), *(relative + 1e-4 * side).tolist())[4] >= size - 1e-9


def test_where_nothing_closes_in_there_is_no_collision_course() -> None:
    assert closest_approach(4.0, 3.0, 0.0, 0.0, 0.0, 0.0) == (0.0, 4.0, 3.0, 0.0, 5.0)  # the same velocity
    assert closest_approach(4.0, 3.0, 0.0, -1.0, 0.0, 0.0)[0] == 0.0  # apart
    same = Sphere(3.0, 0.2, 0.0, 1.0, (2.0, 0.0, 0.0))
    out = forces([same], np.zeros(3), np.array((2.0, 0.0, 0.0)), np.array((20.0, 0.0, 0.0)), gains())
    assert out[COURSE] == 0.0


def test_the_force_leads_to_the_goal_along_the_last_metre_and_vanishes_only_there() -> None:
    goal, beside = np.array((10.0, 0.0, 0.0)), Sphere(10.6, 1.1, 0.0, 0.5)
    for away_m in np.linspace(0.05, 1.0, 20):
        force = forces([beside], goal - np.array((away_m, 0.0, 0.0)), np.zeros(3), goal, gains())[FORCE : FORCE + 3]
        assert force[0] > 0.5 * 1.5 * away_m
        stuck = forces([beside], goal - np.array((away_m, 0.0, 0.0)), np.zeros(3), goal, gains(modules=""))[FORCE : FORCE + 3]
        assert np.linalg.norm(stuck - force) > 0.0
    assert np.abs(forces([beside], goal, np.zeros(3), goal, gains())[FORCE : FORCE + 3]).max() < 1e-9


@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.0), (0.0, 0.0, -1.0)])
@pytest.mark.parametrize("radius_m", [0.0, 1.0])
def test_on_a_centre_or_an_axis_the_force_is_finite_and_always_the_same(centre: tuple[float, ...], radius_m: float) -> None:
    shapes: list[Shape] = [Sphere(*centre, radius_m), Cylinder(0.0, 0.0, radius_m, -3.0, 3.0)]
    one, two = (forces(shapes, np.zeros(3), np.zeros(3), np.array((5.0, 0.0, 0.0)), gains()) for _ in range(2))
    assert np.isfinite(one[:6]).all()
    np.testing.assert_array_equal(one, two)


def test_the_angle_to_a_body_that_stands_or_of_a_vehicle_that_does_is_a_right_one() -> None:
    for vehicle, body in (((3.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))):
        sphere = Sphere(2.0, 0.0, 0.0, 1.0, body)
        out = forces([sphere], np.zeros(3), np.array(vehicle), np.array((20.0, 0.0, 0.0)), gains())
        assert abs(out[GAIN]) == speed_gain(out[REACH_OUT], 90.0, 0.0)


def test_what_is_beyond_the_farthest_reach_changes_nothing() -> None:
    generator = np.random.default_rng(4)
    near: list[Shape] = [Sphere(3.0, 1.0, 0.0, 1.0), Sphere(-2.0, -4.0, 1.0, 0.5)]
    angles = generator.uniform(0.0, 2.0 * math.pi, 80)
    far: list[Shape] = [Sphere(30.0 * math.cos(a), 30.0 * math.sin(a), 0.0, 1.0) for a in angles]
    here, velocity, goal = np.zeros(3), np.array((2.0, 0.0, 0.0)), np.array((20.0, 0.0, 0.0))
    np.testing.assert_allclose(
        forces(far + near, here, velocity, goal, gains(horizon_s=3.0))[:6],
        forces(near, here, velocity, goal, gains(horizon_s=3.0))[:6],
        rtol=1e-12,
    )


def test_head_on_everybody_passes_on_the_same_hand() -> None:
    assert passing_side(0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 1.0) == (0.0, 1.0, 0.0)  # northwards: to the east, the right
    assert passing_side(0.0, 0.0, 0.0, 0.0, -3.0, 0.0, 1.0) == (0.0, -1.0, 0.0)


@FEW
@given(vector, vector, vector, vector, st.booleans())
def test_the_return_force_never_leads_away_from_the_line_and_brakes_only_on_the_way_to_it(
    place: Array, velocity: Array, start: Array, goal: Array, zones: bool
) -> None:
    length = float(np.linalg.norm(goal - start))
    used = gains(return_law="zones" if zones else "damped")
    force = np.array(return_force(place, velocity, start, goal, used))
    if length < 1e-3:
        return
    along = (goal - start) / length
    to_line = (goal - place) - ((goal - place) @ along) * along
    assert abs(force @ along) < 1e-9 * max(1.0, float(np.linalg.norm(force))) * 10.0
    if velocity @ to_line <= 0.0:
        assert force @ to_line >= -1e-9
    assert not np.array(return_force(place, velocity, start, goal, gains())).any()


def test_the_return_force_by_zones_is_the_printed_one() -> None:
    start, goal, still = np.zeros(3), np.array((10.0, 0.0, 0.0)), np.zeros(3)
    used = gains(return_law="zones")

    def at(east: float, speed: float = 0.0) -> float:
        return float(return_force(np.array((4.0, east, 0.0)), np.array((0.0, speed, 0.0)), start, goal, used)[1])

    assert at(-4.0) == pytest.approx(0.5 * 4.0)  # zone 1: k1 n
    assert at(-2.0, 3.0) == pytest.approx(-0.5 * 9.0 / (2.0 - 0.9))  # zone 2, on the way to the line: braked
    assert at(-2.0, -3.0) == 0.0  # and away from it: not pushed further
    assert at(-0.6) == pytest.approx(0.5 * 0.6 * 0.6)  # zone 3: k3 |n| n
    assert return_force(np.array((4.0, 0.0, 0.0)), still, start, goal, used) == (0.0, 0.0, 0.0)


def test_braking_stops_within_the_room_and_never_drives_on() -> None:
    used = gains()
    assert braking_m_s2(2.0, 4.5, 2.0, 1.0, 1.0, used) == pytest.approx(0.5)
    assert braking_m_s2(-2.0, 4.5, 2.0, 1.0, 1.0, used) == 0.0
    assert braking_m_s2(2.0, 4.5, 2.0, math.cos(0.25 * math.pi), 1.0, used) == 0.0
    assert braking_m_s2(6.0, 0.0, 6.0, 1.0, 1.0, used) == used.braking_m_s2
    for closing, gap, speed, ahead in np.random.default_rng(1).uniform(-7.0, 7.0, (200, 4)):
        deceleration = braking_m_s2(closing, gap, abs(speed), ahead / 7.0, 1.0, used)
        assert 0.0 <= deceleration <= used.braking_m_s2


@FEW
@given(st.floats(-2.0, 12.0), st.floats(0.0, 5.0), st.floats(0.0, 2.0), st.floats(0.0, 3.0), st.booleans())
def test_activation_grows_with_speed_and_size(closing: float, speed: float, more: float, radius: float, printed: bool) -> None:
    used = gains()._replace(printed=float(printed), obstacle_s=5.0)
    least = activation_m(closing, speed, radius, used)
    assert used.reach_min_m <= least <= used.reach_max_m
    assert activation_m(closing + more, speed + more, radius, used) >= least
    assert activation_m(closing, speed, radius + more, used) >= least


def test_the_fuzzy_gain_is_monotone_but_for_the_printed_swap() -> None:
    table = np.array([[speed_gain(d, a, 0.0) for a in np.linspace(-10, 190, 60)] for d in np.linspace(4, 16, 60)])
    assert table.min() >= 0.05
    assert table.max() <= 0.25
    assert (np.diff(table, axis=0) >= -1e-12).all()
    assert (np.diff(table, axis=1) >= -1e-12).all()
    assert speed_gain(DISTANCES_M[1], ANGLES_DEG[1], 1.0) < speed_gain(DISTANCES_M[1], ANGLES_DEG[0], 1.0)


@FEW
@given(vector, vector, st.floats(0.01, 1.0), st.floats(0.01, 1.0))
def test_limits_of_change_are_kept(wanted: Array, before: Array, turn_max: float, change_max: float) -> None:
    limited = wanted.copy()
    limit_turn(limited, before, turn_max)
    size, old = float(np.linalg.norm(limited)), float(np.linalg.norm(before))
    assert size <= float(np.linalg.norm(wanted)) + 1e-9
    if size > 0.01 and old > 0.01:
        assert math.acos(min(1.0, float(limited @ before) / size / old)) <= turn_max + 1e-6
    limit_change(limited, before, change_max)
    assert float(np.linalg.norm(limited - before)) <= change_max + 1e-9


@FEW
@given(st.integers(0, 2**31), st.floats(0.3, 2.0))
def test_the_barrier_keeps_its_distance_for_ever(seed: int, alpha: float) -> None:
    """Exact states, a velocity that is flown at once, one convex body that moves straight on (property 8)."""
    generator = np.random.default_rng(seed)
    shape = OrientedBox(0.0, 0.0, 2.0, 1.0, -1.0, 1.0, 0.4, tuple(generator.uniform(-1.5, 1.5, 3)))
    bodies, place, kept_m, dt_s = bodies_of([shape]), np.array((3.0, 2.0, 0.5)), 0.5, 0.1
    which, gaps = np.zeros(1, dtype=np.int64), np.zeros((1, 4))
    goes = generator.uniform(-6.0, 6.0, 3)
    for step in range(60):
        count = nearest_bodies(bodies, *place.tolist(), step * dt_s, math.inf, which, gaps)
        velocity = goes.copy()
        filter_velocity(bodies, which, gaps, count, velocity, kept_m, BARRIER, alpha, 3.0, 0.1, np.zeros(1))
        place = place + dt_s * velocity
        nearest_bodies(bodies, *place.tolist(), (step + 1) * dt_s, math.inf, which, gaps)
        assert gaps[0, 0] >= kept_m - 1e-9
