from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.space.broad_phase import near_gap
from flightapp.space.contact import TOUCHING_M
from flightapp.space.random_scene import PAPER_SEEDS, PAPER_WAYS, random_scene
from flightapp.space.shapes import Cylinder, OrientedBox, Shape, Sphere, bodies_of
from flightapp.space.way import RESOLUTION_M
from flightapp.space.world import World
from tests.space.shapes import point, shape, velocity

shapes = st.lists(shape, min_size=1, max_size=6)


def at_rest(given: list[Shape]) -> World:
    rows = bodies_of(given)
    rows[:, 9:] = 0.0
    return World.of_bodies(rows)


@settings(max_examples=40, deadline=None)
@given(shapes, point, point, st.floats(0.0, 3.0))
def test_a_way_is_free_exactly_where_dense_samples_are(
    given: list[Shape], start: np.ndarray, end: np.ndarray, gap: float
) -> None:
    world = at_rest(given)
    count = 2 + math.ceil(float(np.linalg.norm(end - start)) / 0.05)
    least = min(world.signed_distance_m(start + share * (end - start)) for share in np.linspace(0.0, 1.0, count))
    if world.is_way_free(start, end, gap):
        assert least >= gap - 1e-9
    else:
        assert least <= gap + RESOLUTION_M / 2 + 0.025 + 1e-9


@settings(max_examples=50, deadline=None)
@given(shapes, point)
def test_the_broad_phase_loses_nothing_within_its_reach(given: list[Shape], where: np.ndarray) -> None:
    world = at_rest(given)
    assert near_gap(world.resting, world.cells, *where) == min(world.cells.reach_m, world.signed_distance_m(where))


def test_a_long_wall_is_near_far_from_its_centre() -> None:
    world = World.of([OrientedBox(0.0, 0.0, 60.0, 0.5, heading_rad=math.pi / 4)])
    end = 30.0 * math.cos(math.pi / 4)
    assert near_gap(world.resting, world.cells, end + 1.0, end, 0.0) < 1.0
    assert not world.is_way_free(np.array([end, end - 3.0, 0.0]), np.array([end - 3.0, end, 0.0]), 0.25)


@settings(max_examples=40, deadline=None)
@given(shapes, point, velocity, st.floats(0.1, 1.0))
def test_contact_is_never_told_too_late(given: list[Shape], start: np.ndarray, flown: np.ndarray, radius: float) -> None:
    world = World.of(given)
    contact = world.first_contact(start, np.array(flown), radius, 4.0)
    until = 4.0 if contact is None else contact.t_s
    for t_s in np.arange(0.0, until, 0.02):
        assert world.signed_distance_m(start + t_s * np.array(flown), float(t_s)) >= radius
    if contact is not None:
        there = world.gaps(start + contact.t_s * np.array(flown), contact.t_s)[contact.body, 0]
        assert there <= radius + TOUCHING_M


def test_contact_with_what_comes_and_with_what_stands_in_the_way() -> None:
    world = World.of([Sphere(20.0, 0.0, 0.0, 1.0, (-3.0, 0.0, 0.0)), Cylinder(30.0, 0.0, 2.0)])
    contact = world.first_contact(np.zeros(3), np.array([2.0, 0.0, 0.0]), 0.5, 10.0)
    assert contact is not None
    assert contact.body == 0
    assert contact.t_s == pytest.approx(18.5 / 5.0, abs=1e-3)
    assert world.first_contact(np.zeros(3), np.array([2.0, 0.0, 0.0]), 0.5, 3.0) is None
    assert world.first_contact(np.zeros(3), np.array([0.0, 2.0, 0.0]), 0.5, 3.0) is None


@pytest.mark.parametrize("way", PAPER_WAYS)
def test_the_papers_scenes_are_the_same_every_time_and_keep_their_spacing(way: str) -> None:
    for seed in PAPER_SEEDS:
        scene = random_scene(seed, way)
        assert scene.shapes == random_scene(seed, way).shapes
        assert len(scene.shapes) == 17
        centres = bodies_of(scene.shapes)[:, 1:3]
        spread = np.linalg.norm(centres[:, None] - centres, axis=2) + 1e3 * np.eye(17)
        assert spread.min() >= 20.0
        world = World.of(scene.shapes)
        for end in (scene.start_ned_m, scene.goal_ned_m):
            assert world.signed_distance_m(np.array([*end[:2], -1.0])) >= 12.0


def test_what_does_not_fit_is_said() -> None:
    with pytest.raises(InputError, match=r"obstacles = 60: only .* fit with 20 m"):
        random_scene(0, obstacles=60, spacing_m=20.0)


def test_a_gap_beyond_the_reach_is_refused() -> None:
    with pytest.raises(ValueError, match=r"gap_m = 11\.5"):
        World.of([]).is_way_free(np.zeros(3), np.ones(3), 11.5)


@pytest.mark.parametrize(
    ("start", "end"), [((math.nan, 0.0, -5.0), (10.0, 0.0, -5.0)), ((0.0, 0.0, -5.0), (math.inf, 0.0, -5.0))]
)
def test_a_way_that_does_not_begin_and_end_somewhere_is_not_free_and_the_question_ends(
    start: tuple[float, ...], end: tuple[float, ...]
) -> None:
    world = World.of([Cylinder(50.0, 0.0, 1.0)])
    assert not world.is_way_free(np.array(start), np.array(end), 1.0)
    assert world.is_way_free(np.array((0.0, 0.0, -5.0)), np.array((10.0, 0.0, -5.0)), 1.0)
