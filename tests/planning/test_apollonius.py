"""Properties of the interception game (section 10)."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.ac2f.apollonius import Game, solve
from flightapp.planning.ac2f.apollonius_kernel import depth_m, dominance
from flightapp.planning.plane import Point, Segment
from tests.planning import apollonius_reference as reference

coordinate = st.floats(-40.0, 40.0).map(lambda value: round(value, 3))
place = st.tuples(coordinate, coordinate)
above = st.tuples(st.floats(20.0, 60.0), coordinate)
ratio = st.floats(1.05, 3.0)
LINE: tuple[Segment, ...] = (((0.0, -200.0), (0.0, 200.0)),)


def game(pursuers: list[Point], evader: Point, ratios: list[float], sides: tuple[Segment, ...] = LINE) -> Game:
    return solve(pursuers, evader, ratios, rows(sides))


def rows(sides: tuple[Segment, ...]) -> Array:
    return np.array(sides, dtype=np.float64).reshape(-1, 4)


def region(pursuer: Point, evader: Point, ratio: float) -> Array:
    out = np.empty(6)
    dominance(*pursuer, *evader, ratio, out)
    return out


def regions_contain(regions: Array, point: Point) -> bool:
    return all(depth_m(row, *point) >= -1e-6 * (1.0 + 1e-6 * row[3]) for row in regions)


@given(
    st.lists(st.tuples(place, st.one_of(ratio, st.floats(0.6, 2.5), st.just(1.0))), min_size=1, max_size=7),
    place,
    st.lists(place, min_size=2, max_size=5),
    st.booleans(),
)
def test_the_kernel_agrees_with_plain_python(
    pursuers: list[tuple[Point, float]], evader: Point, corners: list[Point], closed: bool
) -> None:
    if closed:
        corners = [*corners, corners[0]]
    sides = tuple(itertools.pairwise(corners))
    places, ratios = [p for p, _ in pursuers], [r for _, r in pursuers]
    expected = reference.solve(places, evader, ratios, sides, closed=closed)
    found = solve(places, evader, ratios, rows(sides), closed=closed)
    assert found.contested == expected.contested
    assert found.distance_m == pytest.approx(expected.distance_m, abs=1e-6)
    circles = [(*r.centre, r.radius_m) for r in expected.regions if r.kind != "half-plane"]
    np.testing.assert_allclose(np.array(found.circles()).reshape(-1, 3), np.array(circles).reshape(-1, 3), rtol=1e-9, atol=1e-9)
    if math.dist(found.point, expected.point) < 1e-6:  # where two points are equally good, either may be taken
        assert tuple(found.active > 0.0) == expected.active
        for pursuer, goal, wanted in zip(places, found.goals, expected.goals, strict=True):
            assert math.dist(pursuer, goal) == pytest.approx(math.dist(pursuer, wanted), abs=1e-3)


@given(
    st.lists(st.tuples(place, st.one_of(ratio, st.floats(0.6, 2.5), st.just(1.0))), min_size=1, max_size=4),
    place,
    st.lists(place, min_size=2, max_size=4),
    st.booleans(),
)
def test_the_union_is_as_good_for_the_evader_as_its_best_single_region(
    pursuers: list[tuple[Point, float]], evader: Point, corners: list[Point], closed: bool
) -> None:
    sides = tuple(itertools.pairwise([*corners, corners[0]] if closed else corners))
    places, ratios = [p for p, _ in pursuers], [r for _, r in pursuers]
    expected = reference.solve(places, evader, ratios, sides, closed=closed, union=True)
    found = solve(places, evader, ratios, rows(sides), closed=closed, union=True)
    assert found.contested == expected.contested
    assert found.distance_m == pytest.approx(expected.distance_m, abs=1e-6)
    assert found.distance_m <= solve(places, evader, ratios, rows(sides), closed=closed).distance_m + 1e-5
    for row in found.goals.tolist():  # goals are the game point or lie on the edge of the union, never in it
        assert math.dist(row, found.point) < 1e-9 or max(depth_m(region, *row) for region in found.regions) < 1e-4


@given(st.lists(st.tuples(place, st.floats(1.05, 3.0)), min_size=9, max_size=25), above)
def test_many_pursuers_play_as_their_pairs_do(pursuers: list[tuple[Point, float]], evader: Point) -> None:
    """In the plane two of the regions already fix the game point, where nothing but regions and a line is in play."""
    places, ratios = [p for p, _ in pursuers], [r for _, r in pursuers]
    found = game(places, evader, ratios)
    assert all(depth_m(row, *found.point) > -1e-3 for row in found.regions)
    pairs = itertools.combinations(range(len(places)), 2)
    best = max(game([places[i], places[j]], evader, [ratios[i], ratios[j]]).distance_m for i, j in pairs)
    assert found.distance_m == pytest.approx(best, abs=1e-3)


@given(st.lists(st.tuples(place, st.floats(1.05, 3.0)), min_size=1, max_size=4), place, above)
def test_adding_a_pursuer_of_another_speed_never_enlarges_the_region(
    pursuers: list[tuple[Point, float]], another: Point, evader: Point
) -> None:
    places, ratios = [p for p, _ in pursuers], [r for _, r in pursuers]
    before = game(places, evader, ratios)
    after = game([*places, another], evader, [*ratios, 1.2])
    assert after.distance_m >= before.distance_m - 1e-4
    assert regions_contain(before.regions, after.point)


@given(st.lists(place, min_size=1, max_size=4), place, above, ratio)
def test_adding_a_pursuer_never_moves_the_game_point_nearer_to_the_boundary(
    pursuers: list[Point], another: Point, evader: Point, speed_ratio: float
) -> None:
    before = game(pursuers, evader, [speed_ratio] * len(pursuers))
    after = game([*pursuers, another], evader, [speed_ratio] * (len(pursuers) + 1))
    assert after.distance_m >= before.distance_m - 1e-4
    assert regions_contain(before.regions, after.point)


@given(st.lists(st.tuples(place, st.floats(0.6, 2.5)), min_size=1, max_size=4), above)
def test_the_game_point_is_in_every_region(pursuers: list[tuple[Point, float]], evader: Point) -> None:
    found = game([p for p, _ in pursuers], evader, [r for _, r in pursuers])
    assert all(depth_m(row, *found.point) > -1e-3 for row in found.regions)


@given(st.lists(place, min_size=1, max_size=3), above, ratio, st.floats(-3.1, 3.1), coordinate, coordinate)
def test_the_distance_is_invariant_under_rotation_and_translation(
    pursuers: list[Point], evader: Point, speed_ratio: float, angle: float, north: float, east: float
) -> None:
    def moved(point: Point) -> Point:
        cos, sin = math.cos(angle), math.sin(angle)
        return cos * point[0] - sin * point[1] + north, sin * point[0] + cos * point[1] + east

    ratios = [speed_ratio] * len(pursuers)
    here = game(pursuers, evader, ratios)
    sides = tuple((moved(a), moved(b)) for a, b in LINE)
    there = game([moved(p) for p in pursuers], moved(evader), ratios, sides)
    assert there.distance_m == pytest.approx(here.distance_m, abs=1e-4)
    assert there.contested == here.contested or here.distance_m < 1e-3


@given(place, above, place)
def test_near_equal_speed_is_continuous(pursuer: Point, evader: Point, point: Point) -> None:
    if math.dist(pursuer, evader) < 1.0:
        return
    middle = depth_m(region(pursuer, evader, 1.0), *point)
    for speed_ratio in (1.0 - 1e-5, 1.0 + 1e-5):
        assert depth_m(region(pursuer, evader, speed_ratio), *point) == pytest.approx(middle, abs=0.1)


@given(place, above, st.floats(0.3, 3.0), place)
def test_a_region_is_where_the_evader_is_no_later(pursuer: Point, evader: Point, speed_ratio: float, point: Point) -> None:
    margin = math.dist(point, pursuer) - speed_ratio * math.dist(point, evader)
    if abs(margin) > 1e-3 and math.dist(pursuer, evader) > 1e-3:
        assert (depth_m(region(pursuer, evader, speed_ratio), *point) >= 0.0) == (margin > 0.0)


def test_head_on_the_point_is_where_both_arrive() -> None:
    found = game([(0.0, 0.0)], (30.0, 0.0), [2.0])
    assert found.contested
    assert found.point == pytest.approx((20.0, 0.0))
    assert found.goals.tolist() == [list(found.point)]


def test_the_boundary_in_reach_is_not_contested_and_the_nearest_point_is_taken() -> None:
    found = game([(40.0, 0.0)], (5.0, 3.0), [1.5])
    assert not found.contested
    assert found.point == pytest.approx((0.0, 3.0))


def test_of_the_places_on_the_boundary_that_the_evader_wins_the_one_it_reaches_first_is_taken() -> None:
    found = game([(0.0, -3.0)], (5.0, 0.0), [1.1])
    assert not found.contested
    assert found.point[0] == pytest.approx(0.0, abs=1e-9)
    assert math.dist(found.point, (0.0, -3.0)) == pytest.approx(1.1 * math.dist(found.point, (5.0, 0.0)))


def test_equal_speed_leaves_the_nearer_half_plane() -> None:
    assert game([(0.0, 0.0)], (30.0, 0.0), [1.0]).point == pytest.approx((15.0, 0.0))
    assert not game([(0.0, 0.0)], (30.0, 20.0), [1.0]).contested, "it reaches the line beside the pursuer"
    assert game([(0.0, 0.0), (0.0, 40.0)], (30.0, 20.0), [1.0, 1.0]).point == pytest.approx((25.0 / 3.0, 20.0))


def test_an_evader_past_the_line_is_as_near_to_it_as_one_before_it() -> None:
    past, before = game([(10.0, 0.0)], (-20.0, 3.0), [1.5]), game([(-10.0, 0.0)], (20.0, 3.0), [1.5])
    assert past.contested == before.contested
    assert past.distance_m == pytest.approx(before.distance_m)


@given(st.lists(place, min_size=1, max_size=3), above)
def test_the_game_near_equal_speed_is_continuous(pursuers: list[Point], evader: Point) -> None:
    if min(math.dist(p, evader) for p in pursuers) < 1.0:
        return
    exact, above_one = (game(pursuers, evader, [r] * len(pursuers)) for r in (1.0, 1.0 + 1e-6))
    if exact.contested and above_one.contested:
        assert above_one.distance_m == pytest.approx(exact.distance_m, abs=0.1)


def test_a_faster_evader_reaches_the_boundary() -> None:
    found = game([(10.0, 0.0)], (30.0, 0.0), [0.5])
    assert not found.contested
    assert found.distance_m == pytest.approx(0.0, abs=1e-9)


def test_coincident_pursuer_leaves_only_the_evader_itself() -> None:
    for speed_ratio in (1.0, 2.0):
        found = game([(30.0, 0.0)], (30.0, 0.0), [speed_ratio])
        assert found.point == pytest.approx((30.0, 0.0))


def test_inside_a_closed_boundary_the_game_is_lost() -> None:
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    sides = tuple(zip(corners, [*corners[1:], corners[0]], strict=True))
    found = solve([(20.0, 5.0)], (5.0, 5.0), [2.0], rows(sides), closed=True)
    assert not found.contested
    assert found.goals.tolist() == [[5.0, 5.0]]


def test_inactive_pursuers_get_another_goal_on_the_edge() -> None:
    found = game([(2.0, 0.0), (3.0, 40.0)], (30.0, 0.0), [2.0, 2.0])
    assert found.active.tolist() == [1.0, 0.0]
    assert tuple(found.goals[0]) == found.point
    assert math.dist(found.goals[0], found.goals[1]) == pytest.approx(3.0)
    assert regions_contain(found.regions, (found.goals[1][0], found.goals[1][1]))


def test_a_polygon_is_defended_at_its_nearest_side() -> None:
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    sides = tuple(zip(corners, [*corners[1:], corners[0]], strict=True))
    found = solve([(12.0, 5.0)], (40.0, 5.0), [2.0], rows(sides), closed=True)
    assert found.contested
    assert found.point[1] == pytest.approx(5.0)
    assert found.distance_m == pytest.approx(reference.distance_to(found.point, sides))
