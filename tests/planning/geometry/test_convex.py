"""Convex cells: clipping, centroid, nearest point, hull, half-planes; shapely and a solver as independent oracles."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, currently_in_test_context, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from flightapp.core.types import Array
from flightapp.planning.capture import widest_gap_rad
from flightapp.planning.geometry.convex import centroid, clipped, nearest_in
from flightapp.planning.geometry.half_planes import add_polygons, add_rounds
from flightapp.planning.geometry.hull import hull_distance_m
from flightapp.planning.geometry.polygons import polygons

FEW = settings(max_examples=40, deadline=None)
coordinate = st.floats(-10.0, 10.0).map(lambda value: round(value, 3))
place = st.tuples(coordinate, coordinate)
places = st.lists(place, min_size=3, max_size=8, unique=True)


def hull_of(points: list[tuple[float, float]]) -> Array:
    hull = shapely.MultiPoint(points).convex_hull
    if currently_in_test_context():
        assume(hull.geom_type == "Polygon" and hull.area > 0.1)
    return np.ascontiguousarray(np.asarray(hull.exterior.coords)[:-1])


def plane_to(corners: Array, own: tuple[float, float], reach_m: float = 0.0) -> Array:
    planes = np.zeros((1, 3))
    add_polygons(*own, corners, np.array([0, len(corners)]), reach_m, planes, 0)
    return planes[0]


@FEW
@given(places, place, st.floats(-math.pi, math.pi), st.floats(-5.0, 10.0))
def test_a_clipped_polygon_is_what_the_half_plane_leaves(
    points: list[tuple[float, float]], own: tuple[float, float], angle: float, room: float
) -> None:
    corners, out = hull_of(points), np.zeros((20, 2))
    normal = np.array((math.cos(angle), math.sin(angle)))
    kept = clipped(corners, len(corners), *own, *normal, room, out)
    edge, along = np.array(own) + room * normal, 100.0 * np.array((-normal[1], normal[0]))
    half = shapely.Polygon([edge + along, edge - along, edge - along - 100.0 * normal, edge + along - 100.0 * normal])
    expected = shapely.Polygon(corners).intersection(half).area
    assert centroid(out, kept)[2] == pytest.approx(expected, abs=1e-6)


@FEW
@given(places, st.sampled_from([0.0, 1e6]))
def test_the_centroid_is_shapelys_wherever_the_polygon_lies(points: list[tuple[float, float]], shift: float) -> None:
    corners = hull_of(points)
    n, e, area = centroid(corners + shift, len(corners))
    expected = shapely.Polygon(corners)
    assert area == pytest.approx(expected.area, rel=1e-6)
    assert (n - shift, e - shift) == pytest.approx((expected.centroid.x, expected.centroid.y), abs=1e-6)


@FEW
@given(places, place, place)
def test_the_nearest_point_of_a_polygon_is_a_projection(
    points: list[tuple[float, float]], a: tuple[float, float], b: tuple[float, float]
) -> None:
    corners = hull_of(points)
    polygon = shapely.Polygon(corners)
    found = nearest_in(corners, len(corners), *a)
    assert math.dist(found, a) == pytest.approx(polygon.distance(shapely.Point(a)), abs=1e-9)
    assert nearest_in(corners[::-1].copy(), len(corners), *a) == pytest.approx(found, abs=1e-9), "either way round"
    assert nearest_in(corners, len(corners), *found) == pytest.approx(found, abs=1e-9), "it stays"
    assert math.dist(found, nearest_in(corners, len(corners), *b)) <= math.dist(a, b) + 1e-9, "it brings nothing apart"


@FEW
@given(places, place, st.integers(0, 7))
def test_the_plane_before_a_polygon_touches_it_and_has_it_on_the_far_side(
    points: list[tuple[float, float]], own: tuple[float, float], turn: int
) -> None:
    corners = hull_of(points)
    distance = shapely.Polygon(corners).distance(shapely.Point(own))
    assume(distance > 1e-3)
    n, e, room = plane_to(corners, own)
    assert room == pytest.approx(distance, abs=1e-9)
    beyond = (corners - own) @ (n, e) - room
    assert beyond.min() == pytest.approx(0.0, abs=1e-9)
    assert plane_to(np.roll(corners, turn, axis=0).copy(), own) == pytest.approx((n, e, room))
    assert plane_to(corners, own, 0.4)[2] == pytest.approx(room - 0.4), "the buffer is in metres, whatever the distance"


def test_the_plane_solves_the_papers_quadratic_programme() -> None:
    random = np.random.default_rng(7)
    for _ in range(6):
        corners = hull_of([tuple(row) for row in random.uniform(2.0, 6.0, (6, 2))])
        n, e, room = plane_to(corners, (0.0, 0.0))
        constraint = {"type": "ineq", "fun": lambda a, rows=corners: rows @ a - 1.0}
        solved = minimize(lambda a: a @ a, np.array((1.0, 1.0)), jac=lambda a: 2.0 * a, constraints=[constraint], method="SLSQP")
        assert solved.x == pytest.approx((n / room, e / room), rel=1e-4)


def test_inside_a_polygon_and_on_its_border_the_plane_leads_out_by_the_nearest_edge() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    assert plane_to(square, (2.0, 0.5), 0.1) == pytest.approx((0.0, 1.0, -0.6))
    assert plane_to(square, (4.0, 2.0), 0.1) == pytest.approx((-1.0, 0.0, -0.1))
    segment = np.array([[0.0, 0.0], [4.0, 0.0]])
    assert plane_to(segment, (6.0, 0.0)) == pytest.approx((-1.0, 0.0, 2.0)), "on the line of a wall, beyond its end"
    assert abs(plane_to(segment, (2.0, 0.0), 0.1)[1]) == 1.0, "on the wall"


@FEW
@given(place, place, st.floats(0.1, 1.0), st.floats(0.1, 1.0))
def test_two_vehicles_share_the_room_between_them(
    a: tuple[float, float], b: tuple[float, float], radius_a: float, radius_b: float
) -> None:
    planes = np.zeros((2, 3))
    reach = radius_a + radius_b
    add_rounds(*a, np.array([[*b, reach, 0.5, 0.0]]), 1, planes, 0)
    add_rounds(*b, np.array([[*a, reach, 0.5, 0.0]]), 1, planes, 1)
    assert planes[0, 2] == pytest.approx(planes[1, 2])
    assert planes[0, 2] + planes[1, 2] == pytest.approx(math.dist(a, b) - reach), "both at their planes are in contact, no more"
    assert (planes[0, 2] >= 0.0) == (math.dist(a, b) >= reach)


@FEW
@given(st.lists(place, min_size=1, max_size=7, unique=True), place)
def test_the_distance_to_the_hull_is_shapelys_and_tells_who_is_enclosed(
    points: list[tuple[float, float]], evader: tuple[float, float]
) -> None:
    team = np.array(points)
    hull, at = shapely.MultiPoint(points).convex_hull, shapely.Point(evader)
    flat = hull.area < 1e-6
    expected = hull.distance(at) if flat or not hull.contains(at) else -hull.exterior.distance(at)
    found = hull_distance_m(team, *evader)
    assert found == pytest.approx(expected, abs=1e-6)
    if not flat and abs(found) > 1e-6:
        gap = widest_gap_rad(np.arctan2(team[:, 1] - evader[1], team[:, 0] - evader[0]))
        assert (found < 0.0) == (gap < math.pi)


@pytest.mark.parametrize("team", [[(1.0, 0.0)], [(-1.0, 0.0), (1.0, 0.0)], [(-1.0, 0.0), (1.0, 0.0), (3.0, 0.0)]])
def test_one_two_or_a_row_of_pursuers_enclose_nothing(team: list[tuple[float, float]]) -> None:
    assert hull_distance_m(np.array(team), 0.0, 0.0) >= 0.0


def test_polygons_as_somebody_draws_them_become_convex_ones() -> None:
    clockwise = [[0, 0], [0, 4], [2, 4], [4, 4], [4, 4], [4, 0]]
    dented = [[0, 0], [4, 0], [4, 4], [2, 1]]
    found = polygons([clockwise, dented, [[0, 0], [1, 1], [2, 2]]])
    assert np.diff(found.starts).tolist() == [4, 3, 2]
    assert shapely.Polygon(found.corners[:4]).exterior.is_ccw
    assert len(found.warnings) == 1
    assert "polygon 1 is not convex" in found.warnings[0]
    for bad in ([[1, 1], [1, 1]], [[0, 0], [1, math.nan]]):
        with pytest.raises(ValueError, match="polygon 0"):
            polygons([bad])
