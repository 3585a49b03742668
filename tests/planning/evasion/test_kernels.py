"""The evaders' compiled geometry against plain references."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon, box

from flightapp.core.types import Array
from flightapp.planning.evasion.avoidance import Avoidance
from flightapp.planning.evasion.boundary_run import nearest_on_sides
from flightapp.planning.evasion.parameters import AvoidingParameters
from flightapp.planning.evasion.voronoi_cell import cell_centroid
from flightapp.planning.plane import Point, nearest_on, planar
from tests.planning.evasion.flight import LIMITS, disc, observation

REACH_M = 10.0


def cell_reference(own: Point, pursuers: Array, discs: Array, inflation_m: float) -> Polygon:
    """The evader's cell in the square around it, by cutting with big polygons."""
    cell = box(own[0] - REACH_M, own[1] - REACH_M, own[0] + REACH_M, own[1] + REACH_M)
    cuts = [(row[0], row[1], 0.5 * math.dist(own, row[:2])) for row in pursuers]
    cuts += [(row[0], row[1], max(0.0, math.dist(own, row[:2]) - row[2] - inflation_m)) for row in discs]
    for north, east, room_m in cuts:
        along = np.array((north - own[0], east - own[1])) / math.dist(own, (north, east))
        across = np.array((-along[1], along[0]))
        corners = [(room_m, -100.0), (room_m, 100.0), (-100.0, 100.0), (-100.0, -100.0)]
        cell = cell.intersection(Polygon([np.array(own) + a * along + b * across for a, b in corners]))
    return cell


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000), st.integers(0, 6), st.integers(0, 12))
def test_the_cells_centroid_is_that_of_the_cut_square(seed: int, pursuers: int, discs: int) -> None:
    random = np.random.default_rng(seed)
    own = planar(random.uniform(-1e3, 1e3, 2))
    team = np.hstack((np.array(own) + random.uniform(-12.0, 12.0, (pursuers, 2)), np.zeros((pursuers, 2))))
    seen = np.array([disc(*(np.array(own) + random.uniform(-12.0, 12.0, 2)), random.uniform(0.2, 2.0)) for _ in range(discs)])
    seen = seen.reshape(-1, 7)
    corners = (own[0] - REACH_M, own[1] - REACH_M, own[0] + REACH_M, own[1] + REACH_M)
    north, east, area = cell_centroid(*own, team, seen, 0.5, 100.0, *corners)
    expected = cell_reference(own, team, seen, 0.5)
    assert area == pytest.approx(expected.area, abs=1e-6)
    if area > 1e-3:
        assert (north, east) == pytest.approx((expected.centroid.x, expected.centroid.y), abs=1e-5)


def test_a_pursuer_in_the_same_place_bounds_nothing() -> None:
    team, none = np.array([[3.0, 4.0, 0.0, 0.0]]), np.zeros((0, 7))
    assert cell_centroid(3.0, 4.0, team, none, 0.5, 15.0, -7.0, -6.0, 13.0, 14.0) == pytest.approx((3.0, 4.0, 400.0))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000), st.integers(1, 6))
def test_the_nearest_point_of_the_boundary(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    sides = random.uniform(-20.0, 20.0, (count, 4))
    if seed % 2:
        sides[0, 2:] = sides[0, :2]
    own = planar(random.uniform(-20.0, 20.0, 2))
    found = nearest_on_sides(sides, *own)
    expected = nearest_on(own, [((a, b), (c, d)) for a, b, c, d in sides.tolist()])
    assert math.dist(found, own) == pytest.approx(math.dist(expected, own), abs=1e-9)
    assert (
        min(abs(math.dist(side[:2], found) + math.dist(found, side[2:]) - math.dist(side[:2], side[2:])) for side in sides) < 1e-9
    )


def field_reference(own: Point, wish: Array, discs: Array, parameters: AvoidingParameters) -> Array:
    """`wish` turned by the repulsion of inflated discs, at the same speed."""
    push = np.zeros(2)
    for north, east, radius, *_ in discs:
        away = np.array(own) - (north, east)
        distance = float(np.hypot(*away))
        gap = distance - radius - LIMITS.body_radius_m - LIMITS.safety_margin_m
        if gap < parameters.field_influence_m:
            push += parameters.field_gain_m2 / max(gap, 0.1) ** 2 * away / distance
    force = float(np.hypot(*push))
    push *= min(1.0, parameters.field_repulsion_max / max(force, 1e-12))
    speed = float(np.hypot(*wish))
    turned = wish / speed + push
    return np.asarray(turned * speed / np.hypot(*turned))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000), st.integers(0, 5))
def test_a_slow_wish_is_turned_by_the_field_and_otherwise_kept(seed: int, count: int) -> None:
    """Far enough from every inflated edge to stop from its small speed, so that only the field acts."""
    random = np.random.default_rng(seed)
    parameters = AvoidingParameters(reaction_s=0.1)
    rows = []
    for _ in range(count):
        bearing, radius = random.uniform(-math.pi, math.pi), random.uniform(0.2, 1.5)
        distance = radius + 0.5 + random.uniform(1.2, 4.0)
        rows.append(disc(distance * math.cos(bearing), distance * math.sin(bearing), radius))
    wish = random.normal(size=2)
    wish *= 0.8 / np.hypot(*wish)
    seen = observation(0.0, (0.0, 0.0), planar(wish), discs=rows)
    found = Avoidance(LIMITS, parameters).velocity(seen, (0.0, 0.0), np.zeros((0, 4)), planar(wish))
    assert found == pytest.approx(field_reference((0.0, 0.0), wish, np.array(rows).reshape(-1, 7), parameters), abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(1.5, 6.0))
def test_a_pursuer_ahead_is_an_obstacle_of_its_distance(bearing: float, distance: float) -> None:
    """The command can be stopped, after the reaction, before the circle that the evader keeps around the pursuer."""
    parameters = AvoidingParameters()
    pursuer = (distance * math.cos(bearing), distance * math.sin(bearing))
    wish = (4.0 * math.cos(bearing), 4.0 * math.sin(bearing))
    seen = observation(0.0, (0.0, 0.0), (0.0, 0.0))
    north, east = Avoidance(LIMITS, parameters).velocity(seen, (0.0, 0.0), np.array([[*pursuer, 0.0, 0.0]]), wish)
    braking = parameters.braking_share * LIMITS.acceleration_max_m_s2
    speed = math.hypot(north, east)
    stop_m = speed * parameters.reaction_s + speed**2 / (2.0 * braking)
    course = math.atan2(east, north)
    ahead, beside = distance * math.cos(bearing - course), abs(distance * math.sin(bearing - course))
    if ahead > 0.0 and beside < parameters.pursuer_distance_m:
        gap = ahead - math.sqrt(parameters.pursuer_distance_m**2 - beside**2)
        assert stop_m < gap + 0.3
