"""The true world: distances are exact, discs cover the obstacles tightly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import Point, Polygon
from shapely.geometry import box as rectangle

from flightapp.config.mission import Box, Cylinder, Obstacles
from flightapp.core.clearance import NO_OBSTACLE_M
from flightapp.sim.world import World

boxes = st.builds(
    Box,
    north_m=st.floats(-20, 20),
    east_m=st.floats(-20, 20),
    length_m=st.floats(0.1, 15),
    width_m=st.floats(0.1, 15),
    height_m=st.floats(0.5, 10),
    heading_deg=st.floats(-180, 180),
)
cylinders = st.builds(
    Cylinder, north_m=st.floats(-20, 20), east_m=st.floats(-20, 20), radius_m=st.floats(0.05, 3), height_m=st.floats(0.5, 10)
)


def outline(item: Box) -> Polygon:
    """x = north, y = east; a heading turns from north to east, i.e. from x to y."""
    flat = rectangle(-item.length_m / 2, -item.width_m / 2, item.length_m / 2, item.width_m / 2)
    return affinity.translate(affinity.rotate(flat, item.heading_deg, origin=(0, 0)), item.north_m, item.east_m)


@given(boxes, st.floats(-30, 30), st.floats(-30, 30), st.floats(-15, 0))
def test_the_distance_to_a_box_is_that_of_its_outline(item: Box, north: float, east: float, down: float) -> None:
    shape, point = outline(item), Point(north, east)
    planar = -shape.exterior.distance(point) if shape.contains(point) else shape.distance(point)
    above = max(0.0, -item.height_m - down)
    expected = planar if above == 0.0 else math.hypot(max(planar, 0.0), above)
    assert World(Obstacles(boxes=(item,))).signed_distance_m(north, east, down) == pytest.approx(expected, abs=1e-6)


@given(cylinders, st.floats(-30, 30), st.floats(-30, 30), st.floats(-15, 0))
def test_the_distance_to_a_cylinder(item: Cylinder, north: float, east: float, down: float) -> None:
    planar = math.hypot(north - item.north_m, east - item.east_m) - item.radius_m
    above = max(0.0, -item.height_m - down)
    expected = planar if above == 0.0 else math.hypot(max(planar, 0.0), above)
    assert World(Obstacles(cylinders=(item,))).signed_distance_m(north, east, down) == pytest.approx(expected, abs=1e-9)


def test_an_empty_world_is_far_from_everything() -> None:
    world = World(Obstacles())
    assert world.signed_distance_m(0.0, 0.0, -5.0) == NO_OBSTACLE_M
    assert world.as_discs().shape == (0, 7)


def test_the_ground_moves_the_obstacles_with_it() -> None:
    obstacles = Obstacles(cylinders=(Cylinder(north_m=0, east_m=0, radius_m=1, height_m=4),))
    assert World(obstacles, ground_down_m=-10.0).signed_distance_m(0.0, 0.0, -12.0) == pytest.approx(-1.0)
    assert World(obstacles, ground_down_m=0.0).signed_distance_m(0.0, 0.0, -12.0) == pytest.approx(8.0)


point = st.tuples(st.floats(-10, 10), st.floats(-10, 10), st.floats(-8, 0))


@given(st.lists(boxes, max_size=2), st.lists(cylinders, max_size=2), point, point)
@settings(max_examples=60, deadline=None)
def test_a_segments_clearance_is_never_too_large(
    some_boxes: list[Box], some_cylinders: list[Cylinder], start: tuple[float, ...], end: tuple[float, ...]
) -> None:
    world = World(Obstacles(boxes=tuple(some_boxes), cylinders=tuple(some_cylinders)))
    a, b = np.array(start), np.array(end)
    sampled = min(world.signed_distance_m(*(a + part * (b - a)).tolist()) for part in np.linspace(0.0, 1.0, 997))
    clearance = world.segment_clearance_m(a, b, 0.35)
    assert clearance <= sampled - 0.35 + 1e-9
    assert clearance >= sampled - 0.35 - 0.011 - np.linalg.norm(b - a) / 997


@given(boxes)
@settings(max_examples=60, deadline=None)
def test_discs_cover_a_box_and_little_else(item: Box) -> None:
    world = World(Obstacles(boxes=(item,)))
    discs = world.as_discs()
    random = np.random.default_rng(0)
    along = random.uniform(-item.length_m / 2, item.length_m / 2, 500)
    across = random.uniform(-item.width_m / 2, item.width_m / 2, 500)
    angle = math.radians(item.heading_deg)
    north = item.north_m + along * math.cos(angle) - across * math.sin(angle)
    east = item.east_m + along * math.sin(angle) + across * math.cos(angle)
    gaps = np.hypot(north[:, None] - discs[:, 0], east[:, None] - discs[:, 1]) - discs[:, 2]
    assert gaps.min(axis=1).max() <= 1e-9
    for disc in discs:
        assert world.signed_distance_m(disc[0], disc[1], -0.1) + disc[2] <= 0.25
    assert np.all(discs[:, 5] == -item.height_m)
    assert np.all(discs[:, 6] == 0.0)
    assert len(discs) <= 30 + 4 * (item.length_m + item.width_m)


def test_a_cylinder_is_one_disc() -> None:
    world = World(Obstacles(cylinders=(Cylinder(north_m=3, east_m=-2, radius_m=0.7, height_m=9),)))
    assert world.as_discs().tolist() == [[3.0, -2.0, 0.7, 0.0, 0.0, -9.0, 0.0]]
