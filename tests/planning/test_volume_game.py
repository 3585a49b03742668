"""The game about the boundary in space: Apollonius spheres, their sections, and the place where the evader is met at the wall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.ac2f import apollonius
from flightapp.planning.ac2f.apollonius_kernel import DISC, HALF_PLANE, depth_m
from flightapp.planning.ac2f.volume.game import SpaceGame, solve
from flightapp.planning.ac2f.volume.sphere import SPACE_COLUMNS, depth_in_space_m, dominance_in_space, section

WALL = np.array([[0.0, -60.0, 0.0, 60.0]])
"""The line north = 0."""
BAND = (-30.0, -1.0)
metre, height, above = st.floats(-30, 30), st.floats(2, 28), st.floats(12, 40)
place = st.tuples(metre, metre, height)
Place = tuple[float, float, float]


def down(place: Place) -> Place:
    return place[0], place[1], -place[2]


def region_of(pursuer: Place, evader: Place, ratio: float, stretch: float = 1.0) -> Array:
    region = np.empty(SPACE_COLUMNS)
    dominance_in_space(*down(pursuer), *down(evader), ratio, stretch, region)
    return region


def stretched_m(a: Array, b: Array, stretch: float) -> float:
    return math.hypot(*(a[:2] - b[:2]), stretch * (a[2] - b[2]))


def game(pursuers: list[Place], evader: Place, ratios: list[float], stretch: float = 3.0, wall: Array = WALL) -> SpaceGame:
    return solve(np.array([down(p) for p in pursuers]), down(evader), ratios, [stretch] * len(pursuers), wall, BAND)


@given(place, place, st.floats(1.05, 4.0), st.floats(0.5, 5.0), metre, metre, metre)
@settings(max_examples=60, deadline=None)
def test_both_need_as_long_to_the_sphere_and_the_evader_is_inside(
    pursuer: Place, evader: Place, ratio: float, stretch: float, n: float, e: float, z: float
) -> None:
    assume(math.dist(pursuer, evader) > 0.5 and math.hypot(n, e, z) > 0.1)
    region = region_of(pursuer, evader, ratio, stretch)
    assert depth_in_space_m(region, evader[0], evader[1], -stretch * evader[2]) > 0.0
    out = region[4] * np.array((n, e, z)) / math.hypot(n, e, z)
    on_it = region[1:4] + out
    on_it[2] /= stretch
    to_pursuer = stretched_m(on_it, np.array(down(pursuer)), stretch)
    to_evader = stretched_m(on_it, np.array(down(evader)), stretch)
    assert to_pursuer == pytest.approx(ratio * to_evader, rel=1e-6, abs=1e-6)
    assert depth_in_space_m(region, *(region[1:4] + 0.5 * out)) > 0.0 > depth_in_space_m(region, *(region[1:4] + 2.0 * out))


@given(place, place, st.floats(0.4, 3.0), metre, metre, height)
@settings(max_examples=60, deadline=None)
def test_a_section_holds_what_the_region_holds_at_that_height(
    pursuer: Place, evader: Place, ratio: float, n: float, e: float, at: float
) -> None:
    assume(math.dist(pursuer, evader) > 0.5)
    for lam in (ratio, 1.0):
        region, planar = region_of(pursuer, evader, lam, 2.0), np.empty(6)
        inside = depth_in_space_m(region, n, e, -2.0 * at)
        assume(abs(inside) > 1e-3)
        assert (section(region, -2.0 * at, planar) and depth_m(planar, n, e) > 0.0) == (inside > 0.0)


@given(place, place, metre, metre, height)
@settings(max_examples=40, deadline=None)
def test_equal_speed_is_the_limit_from_both_sides(pursuer: Place, evader: Place, n: float, e: float, at: float) -> None:
    assume(math.dist(pursuer, evader) > 1.0)
    half_space = region_of(pursuer, evader, 1.0)
    assert half_space[0] == HALF_PLANE
    ahead = depth_in_space_m(half_space, n, e, -at)
    for near in (1.0 - 1e-4, 1.0 + 1e-4):
        assert depth_in_space_m(region_of(pursuer, evader, near), n, e, -at) == pytest.approx(ahead, abs=0.05)


@given(st.lists(st.tuples(metre, metre), min_size=1, max_size=4), metre, above, st.lists(st.floats(0.7, 2.5), min_size=4), height)
@settings(max_examples=60, deadline=None)
def test_with_all_at_one_height_it_is_the_planar_game_bit_for_bit(
    pursuers: list[tuple[float, float]], east: float, north: float, ratios: list[float], at: float
) -> None:
    ratios = ratios[: len(pursuers)]
    planar = apollonius.solve(pursuers, (north, east), ratios, WALL)
    spatial = game([(n, e, at) for n, e in pursuers], (north, east, at), ratios)
    assume(all(ratio >= 1.0 for ratio in ratios) or planar.contested == spatial.contested)
    assert spatial.point_ned_m[2] == -at or min(ratios) < 1.0
    if spatial.point_ned_m[2] == -at:
        assert (spatial.point_ned_m[:2], spatial.contested, spatial.distance_m) == (
            planar.point,
            planar.contested,
            planar.distance_m,
        )
        assert spatial.goals[:, :2].tolist() == planar.goals.tolist()
        assert spatial.active.tolist() == planar.active.tolist()


@given(st.lists(place, min_size=1, max_size=3), metre, above, height, st.floats(1.1, 2.5), st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_no_place_of_the_evader_s_region_is_nearer_to_the_wall(
    pursuers: list[Place], east: float, north: float, at: float, ratio: float, seed: int
) -> None:
    evader = (north, east, at)
    found = game(pursuers, evader, [ratio] * len(pursuers))
    regions = found.regions
    assert all(depth_in_space_m(row, *found.point_ned_m[:2], 3.0 * found.point_ned_m[2]) >= -1e-3 for row in regions)
    assert BAND[0] <= found.point_ned_m[2] <= BAND[1]
    random = np.random.default_rng(seed)
    low = regions[:, 1:4] - regions[:, 4:5]
    high = regions[:, 1:4] + regions[:, 4:5]
    places = random.uniform(low.max(axis=0), np.maximum(high.min(axis=0), low.max(axis=0)), (400, 3))
    held = np.array([all(depth_in_space_m(row, *one) > 0.0 for row in regions) for one in places])
    held &= (places[:, 2] >= 3.0 * BAND[0]) & (places[:, 2] <= 3.0 * BAND[1])
    if found.contested:
        assert not held.any() or np.abs(places[held, 0]).min() >= found.distance_m - 0.01
        assert (places[held, 0] > 0.0).all()
    elif held.any():
        assert found.distance_m == pytest.approx(0.0, abs=1e-6)


@given(st.lists(place, min_size=1, max_size=3), place, metre, above, height, st.floats(1.1, 2.5))
@settings(max_examples=40, deadline=None)
def test_another_pursuer_never_helps_the_evader(
    pursuers: list[Place], another: Place, east: float, north: float, at: float, ratio: float
) -> None:
    before = game(pursuers, (north, east, at), [ratio] * len(pursuers))
    after = game([*pursuers, another], (north, east, at), [ratio] * (len(pursuers) + 1))
    assert after.distance_m >= before.distance_m - 0.01
    assert after.contested or not before.contested


@given(st.lists(place, min_size=1, max_size=3), metre, above, height, st.floats(1.1, 2.5), st.floats(-3.1, 3.1), metre, metre)
@settings(max_examples=30, deadline=None)
def test_it_turns_and_moves_with_the_scene(
    pursuers: list[Place], east: float, north: float, at: float, ratio: float, angle: float, n: float, e: float
) -> None:
    cos, sin = math.cos(angle), math.sin(angle)

    def moved(place: Place) -> Place:
        return cos * place[0] - sin * place[1] + n, sin * place[0] + cos * place[1] + e, place[2]

    here = game(pursuers, (north, east, at), [ratio] * len(pursuers))
    ends = [moved((WALL[0, 2 * k], WALL[0, 2 * k + 1], 0.0))[:2] for k in range(2)]
    wall = np.array([[*ends[0], *ends[1]]])
    there = game([moved(p) for p in pursuers], moved((north, east, at)), [ratio] * len(pursuers), wall=wall)
    assert there.distance_m == pytest.approx(here.distance_m, abs=0.01)
    assert there.contested == here.contested or min(here.distance_m, there.distance_m) < 0.01


def test_a_pursuer_below_leaves_the_evader_more_above_and_is_sent_there() -> None:
    low = game([(10.0, 0.0, 4.0)], (30.0, 0.0, 10.0), [1.5])
    level = game([(10.0, 0.0, 10.0)], (30.0, 0.0, 10.0), [1.5])
    assert low.contested
    assert -low.point_ned_m[2] > 10.0
    assert low.distance_m < level.distance_m, "being below costs"
    assert region_of((10.0, 0.0, 4.0), (30.0, 0.0, 10.0), 1.5)[0] == DISC


def test_from_far_below_the_wall_is_lost_over_the_pursuer_s_head() -> None:
    beneath = game([(4.0, 0.0, 2.0)], (12.0, 0.0, 20.0), [1.2])
    assert not beneath.contested
    assert beneath.point_ned_m[0] == pytest.approx(0.0)
    assert -beneath.point_ned_m[2] >= 20.0
    assert game([(4.0, 0.0, 20.0)], (12.0, 0.0, 20.0), [1.2]).contested


def test_right_above_the_pursuer_at_equal_speed_all_heights_above_the_middle_are_the_evader_s() -> None:
    found = game([(20.0, 0.0, 4.0)], (20.0, 0.0, 10.0), [1.0])
    assert not found.contested
    planar = np.empty(6)
    region = region_of((20.0, 0.0, 4.0), (20.0, 0.0, 10.0), 1.0)
    assert section(region, -7.5, planar)
    assert not section(region, -6.5, planar)
