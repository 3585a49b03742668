from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import NO_OBSTACLE_M, disc_clearances_m
from flightapp.space.shapes import (
    Cylinder,
    OrientedBox,
    Shape,
    Sphere,
    SuperquadricCylinder,
    bodies_of,
    bodies_of_discs,
)
from flightapp.space.world import World
from tests.space.shapes import box, cylinder, point, shape, sphere, superquadric

fcl = pytest.importorskip("fcl")
BALL_M = 0.05


def fcl_distance_m(body: Shape, where: np.ndarray) -> float:
    """By GJK of the library: between a small ball and the body, plus the ball's radius."""
    turn = np.eye(3)
    if isinstance(body, Sphere):
        geometry, down = fcl.Sphere(body.radius_m), body.down_m
    else:
        height, down = body.bottom_down_m - body.top_down_m, 0.5 * (body.bottom_down_m + body.top_down_m)
        if isinstance(body, Cylinder):
            geometry = fcl.Cylinder(body.radius_m, height)
        else:
            assert isinstance(body, OrientedBox)
            geometry = fcl.Box(body.length_m, body.width_m, height)
            c, s = math.cos(body.heading_rad), math.sin(body.heading_rad)
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    placed = fcl.CollisionObject(geometry, fcl.Transform(turn, np.array([body.north_m, body.east_m, down])))
    ball = fcl.CollisionObject(fcl.Sphere(BALL_M), fcl.Transform(np.eye(3), where))
    return BALL_M + fcl.distance(ball, placed, fcl.DistanceRequest(), fcl.DistanceResult())


@settings(max_examples=50, deadline=None)
@given(st.one_of(sphere, cylinder, box), point)
def test_outside_it_is_what_an_exact_library_says(body: Shape, where: np.ndarray) -> None:
    ours = World.of([body]).signed_distance_m(where)
    if ours > BALL_M + 1e-3:
        assert ours == pytest.approx(fcl_distance_m(body, where), abs=1e-6)


@settings(max_examples=50, deadline=None)
@given(shape, point, point)
def test_it_changes_no_faster_than_the_way(body: Shape, one: np.ndarray, other: np.ndarray) -> None:
    world = World.of([body])
    change = abs(world.signed_distance_m(one) - world.signed_distance_m(other))
    assert change <= float(np.linalg.norm(one - other)) + 1e-9


@settings(max_examples=50, deadline=None)
@given(shape, point)
def test_the_gradient_is_a_unit_vector_to_the_surface(body: Shape, where: np.ndarray) -> None:
    world = World.of([body])
    distance, gradient = world.signed_distance_and_gradient(where)
    assert float(np.linalg.norm(gradient)) == pytest.approx(1.0, abs=1e-9)
    assert world.signed_distance_m(where - distance * gradient) == pytest.approx(0.0, abs=1e-6)
    assert world.signed_distance_m(where + 2.0 * gradient) >= distance + (2.0 if distance >= 0.0 else 0.0) - 1e-6


@settings(max_examples=30, deadline=None)
@given(superquadric, st.floats(-25, 25), st.floats(-25, 25))
def test_a_superquadric_is_as_far_as_its_edge(body: SuperquadricCylinder, north: float, east: float) -> None:
    middle = 0.5 * (body.top_down_m + body.bottom_down_m)
    tall = SuperquadricCylinder(body.north_m, body.east_m, body.radius_m, body.exponent, heading_rad=body.heading_rad)
    ours = World.of([tall]).signed_distance_m(np.array([north, east, middle]))
    angle = np.linspace(0.0, 0.5 * math.pi, 4001)
    x, y = body.radius_m * np.cos(angle) ** body.exponent, body.radius_m * np.sin(angle) ** body.exponent
    c, s = math.cos(body.heading_rad), math.sin(body.heading_rad)
    ahead, right = c * (north - body.north_m) + s * (east - body.east_m), c * (east - body.east_m) - s * (north - body.north_m)
    sampled = np.hypot(abs(ahead) - x, abs(right) - y)
    coarse = float(np.hypot(np.diff(x), np.diff(y)).max())
    inside = (abs(ahead) / body.radius_m) ** (2 / body.exponent) + (abs(right) / body.radius_m) ** (2 / body.exponent) < 1.0
    assert ours == pytest.approx(-sampled.min() if inside else sampled.min(), abs=coarse + 1e-6)


def test_a_superquadric_of_exponent_one_is_a_cylinder() -> None:
    assert (bodies_of([SuperquadricCylinder(1.0, 2.0, 3.0, 1.0)])[0, :4] == bodies_of([Cylinder(1.0, 2.0, 3.0)])[0, :4]).all()


@settings(max_examples=30, deadline=None)
@given(st.lists(shape, min_size=1, max_size=8), point, st.floats(0, 3), st.integers(1, 4))
def test_the_nearest_are_the_nearest_where_all_have_moved_to(
    shapes: list[Shape], where: np.ndarray, t_s: float, count: int
) -> None:
    world = World.of(shapes)
    gaps = world.gaps(where, t_s)
    alone = [World.of([body]).signed_distance_m(where - t_s * np.array(bodies_of([body])[0, 9:]), 0.0) for body in shapes]
    assert gaps[:, 0] == pytest.approx(alone)
    which, found = world.nearest(where, count, t_s)
    order = np.argsort(gaps[:, 0], kind="stable")[:count]
    assert which.tolist() == order.tolist()
    assert (found == gaps[order]).all()
    assert world.signed_distance_m(where, t_s) == gaps[:, 0].min()


def test_fixed_directions_where_there_is_none_and_nothing_in_an_empty_world() -> None:
    for body in (Sphere(1.0, 2.0, 3.0, 2.0), Cylinder(1.0, 2.0, 2.0), OrientedBox(1.0, 2.0, 4.0, 4.0)):
        distance, gradient = World.of([body]).signed_distance_and_gradient(np.array([1.0, 2.0, 3.0]))
        assert distance == -2.0
        assert gradient.tolist() == [1.0, 0.0, 0.0]
    assert World.of([]).signed_distance_m(np.zeros(3)) == NO_OBSTACLE_M
    assert len(World.of([]).nearest(np.zeros(3), 3)[0]) == 0


def test_observed_discs_are_as_far_as_the_planar_clearance_says() -> None:
    discs = np.array([[3.0, 4.0, 1.0, 1.0, 0.0, -np.inf, np.inf], [-6.0, 0.0, 2.0, 0.0, 0.0, -10.0, 0.0]])
    world = World.of_bodies(bodies_of_discs(discs))
    where = np.array([0.5, -0.5, -5.0])
    assert world.gaps(where)[:, 0] == pytest.approx(disc_clearances_m(where[:2], discs, 0.0))
    assert world.gaps(np.array([-6.0, 0.0, -13.0]))[1, 0] == 3.0


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (Sphere(0.0, 0.0, 0.0, -1.0), "radius_m = -1.0"),
        (Cylinder(0.0, 0.0, 1.0, 5.0, -5.0), "top_down_m = 5.0"),
        (SuperquadricCylinder(0.0, 0.0, 1.0, 2.5), "exponent = 2.5"),
        (Sphere(math.nan, 0.0, 0.0, 1.0), "body 0"),
    ],
)
def test_what_is_no_body_is_refused(body: Shape, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        bodies_of([body])
