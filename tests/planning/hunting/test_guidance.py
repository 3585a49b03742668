"""Trees, key points and what a fast obstacle makes dangerous."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Limits
from flightapp.planning.critics.right_hand import right_turn_rad
from flightapp.planning.guidance.danger import Obstacle, danger_distance_m, is_in_zone, is_past, is_threatened, refuge_m
from flightapp.planning.guidance.key_points import key_points
from flightapp.planning.guidance.tree import Tree, is_barred

LIMITS = Limits(2.0, 0.5, 10.0, 1.0, 0.5, 1.0, 2.0, 0.5)
BOX = (-40.0, -40.0, 40.0, 40.0)
WALL = np.array([[10.0, float(e), 2.0] for e in range(-15, 16, 3)])
"""Between (0, 0) and (20, 0)."""


def grown(seed: int, steps: int = 30) -> Tree:
    tree = Tree((0.0, 0.0), (20.0, 0.0), BOX, 3.0, 2000, seed)
    for _ in range(steps):
        tree.grow(WALL, 100)
    return tree


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_the_way_leads_from_the_start_past_the_wall_to_where_the_goal_is_seen(seed: int) -> None:
    tree = grown(seed)
    assert tree.has_found
    way = tree.way()
    assert way[0] == (0.0, 0.0)
    assert not any(is_barred(WALL, *a, *b) for a, b in itertools.pairwise(way))
    assert not is_barred(WALL, *way[-1], 20.0, 0.0)
    points = key_points(way, WALL)
    assert points[-1] == way[-1]
    assert [point for point in way if point in points] == points
    assert not any(is_barred(WALL, *a, *b) for a, b in itertools.pairwise([way[0], *points]))
    assert key_points([way[0], *points], WALL) == points


def test_the_same_seed_gives_the_same_way_also_in_other_portions() -> None:
    whole = Tree((0.0, 0.0), (20.0, 0.0), BOX, 3.0, 2000, 7)
    whole.grow(WALL, 3000)
    assert grown(7).way() == whole.way()
    assert grown(8).way() != whole.way()


def test_where_the_goal_is_seen_at_once_nothing_is_searched_and_where_there_is_no_way_it_ends() -> None:
    free = Tree((0.0, 0.0), (5.0, 0.0), BOX, 3.0, 200, 1)
    free.grow(WALL, 100)
    assert (free.count, free.has_found) == (1, True)
    round_about = np.array([[5 * math.cos(a), 5 * math.sin(a), 1.5] for a in np.arange(0.0, 6.28, 0.4)])
    shut = Tree((0.0, 0.0), (20.0, 0.0), BOX, 2.0, 100, 1)
    shut.grow(round_about, 10000)
    assert shut.is_exhausted
    assert not shut.has_found
    assert math.hypot(*shut.way()[-1]) < 5.0


def test_a_way_through_an_obstacle_is_refused() -> None:
    with pytest.raises(ValueError, match="between its points 0 and 1"):
        key_points([(0.0, 0.0), (20.0, 0.0)], WALL)


FAST = Obstacle((50.0, 0.0), (-5.66, 0.0), 5.0)


def test_the_danger_grows_with_the_obstacles_speed_and_the_papers_is_beyond_the_sensors() -> None:
    slow = Obstacle((50.0, 0.0), (-1.0, 0.0), 5.0)
    assert danger_distance_m(slow, 1.0, LIMITS, 2.5, "clearing") < danger_distance_m(FAST, 1.0, LIMITS, 2.5, "clearing") < 100.0
    assert danger_distance_m(FAST, 1.0, LIMITS, 2.5, "paper") > 100.0


def test_what_stands_in_its_track_is_threatened_until_it_is_past() -> None:
    length = danger_distance_m(FAST, 1.0, LIMITS, 2.5, "clearing")
    assert is_in_zone((50.0 - length, 4.0), FAST, length)
    assert not is_in_zone((60.0, 0.0), FAST, length)
    assert is_threatened((10.0, 0.0), (1.0, 0.0), FAST, length, 10.0)
    assert not is_threatened((10.0, 40.0), (0.0, 0.0), FAST, length, 10.0)
    assert is_past((60.0, 0.0), (0.0, 0.0), FAST)


def test_the_refuge_is_out_of_the_track_and_reached_before_the_obstacle_comes() -> None:
    length = danger_distance_m(FAST, 0.0, LIMITS, 2.5, "clearing")
    way = refuge_m((10.0, 0.0), 0.5 * math.pi, FAST, length, np.zeros((0, 3)), LIMITS, 3)
    assert way
    assert not is_in_zone(way[-1], FAST, length)
    assert abs(way[-1][1]) > FAST.radius_m


mates = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-2, 2), st.floats(-2, 2))


@settings(max_examples=30, deadline=None)
@given(st.lists(mates, min_size=1, max_size=3), st.floats(-3.1, 3.1))
def test_giving_way_never_turns_left(team: list[tuple[float, float, float, float]], course: float) -> None:
    turn = float(right_turn_rad(np.array(team), 0.0, 0.0, math.cos(course), math.sin(course), course, 10.0, 15.0))
    assert 0.0 <= turn <= math.pi


def test_head_on_both_turn_45_degrees_right_and_one_far_on_the_left_gives_way_itself() -> None:
    ahead = np.array([[8.0, 0.0, -1.0, 0.0]])
    assert right_turn_rad(ahead, 0.0, 0.0, 1.0, 0.0, 0.0, 10.0, 15.0) == pytest.approx(0.25 * math.pi)
    left = np.array([[1.0, -8.0, 0.0, 1.0]])
    assert right_turn_rad(left, 0.0, 0.0, 1.0, 0.0, 0.0, 10.0, 15.0) == 0.0
    gone = np.array([[8.0, 0.0, 2.0, 0.0]])
    assert right_turn_rad(gone, 0.0, 0.0, 1.0, 0.0, 0.0, 10.0, 15.0) == 0.0
