"""Reactive avoidance: the choice against a search without shortcuts, the field in both forms, hold and search."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.ac2f.field import deflected, field_velocity, repulsion, speed_limit_ahead_m_s
from flightapp.planning.ac2f.looking import seen_share
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.safe_velocity import DIRECTIONS, Braking, safe_velocity
from tests.planning.acting import Moment, Pair, random_scene, scene_of
from tests.planning.closed_loop import limits

PARAMETERS = Ac2fParameters()
BRAKING = Braking(4.0, 0.55, reached_excess_cost=1000.0)
SEEDS = st.integers(0, 100_000)


def excess(scene: Array, velocity: Array) -> float:
    """By how much `velocity` (2,) at the origin is too fast before the worst disc, or too slow out of one."""
    worst = 0.0
    for disc in scene:
        relative, place = velocity - disc[3:5], disc[:2]
        speed, closing = math.hypot(*relative), float(relative @ place)
        if disc[5] > 0.0:
            worst = max(worst, min(1.0, 2.0 * disc[5]) + closing / math.hypot(*place))
        if closing <= 0.0:
            continue
        miss2 = float(place @ place) - (closing / speed) ** 2
        if miss2 < disc[2] ** 2:
            gap = max(0.0, closing / speed - math.sqrt(disc[2] ** 2 - miss2))
            worst = max(worst, speed - 4.0 * (math.sqrt(0.55**2 + 2.0 * gap / 4.0) - 0.55))
    return worst


def cost(scene: Array, wish: Array, base: Array, velocity: Array) -> float:
    change = velocity - base
    part = min(1.0, 0.8 / max(1e-9, math.hypot(*change)))
    risk = 1000.0 * excess(scene, base + part * change) + (8.0 * excess(scene, velocity) if part < 1.0 else 0.0)
    speed = math.hypot(*wish)
    along = wish / speed if speed > 0.0 else np.array((1.0, 0.0))
    ahead, across = velocity @ along, velocity[1] * along[0] - velocity[0] * along[1]
    return float(abs(speed - ahead) + 0.3 * abs(across) + 0.1 * math.hypot(*change) + risk)


def candidates(wish: Array) -> list[Array]:
    """The wish, then every direction at every speed."""
    speed, heading = math.hypot(*wish), math.atan2(wish[1], wish[0])
    found = [wish]
    for angle in heading + np.arange(DIRECTIONS) * 2.0 * math.pi / DIRECTIONS:
        direction = np.array((math.cos(angle), math.sin(angle)))
        found += [v * direction for v in (0.0, 0.5 * speed, speed, 1.25, 2.5, 3.75, 5.0)]
    return found


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.just(0.0) | st.floats(0.01, 5.0), st.floats(0.0, 5.0), st.sampled_from([0, 2, 10]))
def test_the_safe_velocity_is_the_cheapest_of_all(seed: int, wished: float, flown: float, discs: int) -> None:
    random = np.random.default_rng(seed)
    scene = random_scene(random, discs)
    scene[:, 5] = np.where(random.random(discs) < 0.2, 0.3, 0.0)
    turn, course = random.uniform(-math.pi, math.pi, 2)
    wish, base = wished * np.array((math.cos(turn), math.sin(turn))), flown * np.array((math.cos(course), math.sin(course)))
    found = np.array(safe_velocity(scene, 0.0, 0.0, *wish, *base, 5.0, BRAKING))
    if excess(scene, wish) == 0.0 and math.hypot(*(wish - base)) <= 0.8:
        assert (found == wish).all()
    least = min(cost(scene, wish, base, velocity) for velocity in candidates(wish))
    assert cost(scene, wish, base, found) == pytest.approx(least, rel=1e-6, abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.floats(0.0, 2.0 * math.pi))
def test_whatever_the_wish_the_way_stays_clear_of_a_wall(seed: int, course: float) -> None:
    """The wish jumps at random, full speed before a wall without a gap and beside pillars: every command leaves room to stop."""
    random = np.random.default_rng(seed)
    discs = np.zeros((24, 6))
    discs[:20, 0], discs[:20, 1], discs[:20, 2] = 6.0, np.linspace(-10.0, 10.0, 20), 1.0
    discs[20:, :2], discs[20:, 2] = ((2.0, 4.0), (2.0, -4.0), (-4.0, 3.0), (-4.0, -3.0)), 0.8
    place, velocity = np.zeros(2), 3.0 * np.array((math.cos(course), math.sin(course)))
    parameters = Ac2fParameters(reaction_s=0.1, response_lag_s=0.0, command_blend=1.0)
    wish = np.zeros(2)
    for period in range(60):
        if period % 5 == 0:
            angle = random.uniform(-math.pi, math.pi)
            wish = 5.0 * np.array((math.cos(angle), math.sin(angle)))
        scene = discs.copy()
        scene[:, :2] -= place
        action = Moment(parameters, scene, (velocity[0], velocity[1])).react((wish[0], wish[1]))
        velocity = np.array((action["velocity_n"], action["velocity_e"]))
        place = place + 0.1 * velocity
        assert (np.hypot(*(discs[:, :2] - place).T) - discs[:, 2]).min() > -0.05


def force(scene: Array, gain: float, influence: float, gap_min: float) -> Array:
    distance = np.hypot(scene[:, 0], scene[:, 1])
    gap = distance - scene[:, 2]
    size = np.where(gap < influence, gain / np.maximum(gap, gap_min) ** 2, 0.0)
    return np.asarray((-scene[:, :2] / distance[:, None] * size[:, None]).sum(axis=0))


@given(SEEDS, st.integers(0, 20), st.floats(0.1, 5.0))
def test_repulsion_and_deflection_against_plain_numpy(seed: int, discs: int, speed: float) -> None:
    scene = random_scene(np.random.default_rng(seed), discs)
    push = force(scene, 0.25, 2.5, 0.1)
    assert repulsion(scene, 0.0, 0.0, 0.25, 2.5, 0.1) == pytest.approx(tuple(push), abs=1e-9)
    capped = push * min(1.0, 0.9 / max(1e-12, math.hypot(*push)))
    north, east = deflected(scene, 0.0, 0.0, speed, 0.0, 0.25, 2.5, 0.9, 0.1)
    assert math.hypot(north, east) == pytest.approx(speed)
    assert math.atan2(east, north) == pytest.approx(math.atan2(capped[1], 1.0 + capped[0]), abs=1e-9)


def stopping_way_m(speed: float, deceleration_m_s2: float, reaction_s: float) -> float:
    return speed * reaction_s + speed**2 / (2.0 * deceleration_m_s2)


def clear_along(scene: Array, direction: Array, way_m: float) -> float:
    """Smallest gap (m) of a point that flies `way_m` from the origin in `direction` (2,), to standing discs."""
    places = np.arange(0.0, way_m, 0.01)[:, None] * direction
    return float((np.hypot(scene[:, 0] - places[:, :1], scene[:, 1] - places[:, 1:]) - scene[:, 2]).min(initial=1.0))


@given(SEEDS, st.integers(1, 20), st.floats(-math.pi, math.pi), st.floats(0.0, 5.0), st.floats(0.0, 0.6))
def test_the_plain_field_follows_the_resultant_and_can_stop_before_every_obstacle_there_and_where_it_moves(
    seed: int, discs: int, course: float, flown: float, reaction_s: float
) -> None:
    scene = random_scene(np.random.default_rng(seed), discs, moving=False)
    moving = np.array((math.cos(course), math.sin(course)))
    velocity = np.array(field_velocity(scene, 0.0, 0.0, 3.0, 0.0, *(flown * moving), 0.25, 2.5, 5.0, reaction_s))
    resultant = np.array((1.0, 0.0)) + force(scene, 0.25, 2.5, 1e-3)
    speed = math.hypot(*velocity)
    assert speed <= 3.0 + 1e-9
    assert velocity @ resultant == pytest.approx(speed * math.hypot(*resultant))
    way_m = stopping_way_m(speed, 5.0, reaction_s)
    assert clear_along(scene, resultant / math.hypot(*resultant), way_m) > -1e-6
    if flown > 1e-3:
        assert clear_along(scene, moving, way_m) > -1e-6


def test_the_plain_field_slows_down_for_the_direction_of_motion_although_it_turns_away() -> None:
    scene = scene_of([(2.0, 0.0, 1.0, 0.0, 0.0)])
    turning = (0.0, 3.0, 3.0, 0.0)  # wanted east, moving north
    assert math.hypot(*field_velocity(scene, 0.0, 0.0, *turning, 1e-9, 2.5, 4.0, 0.5)) == pytest.approx(4.0 * (0.75**0.5 - 0.5))
    assert field_velocity(scene, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 1e-9, 2.5, 4.0, 0.5) == pytest.approx((0.0, 3.0), abs=1e-6)


def test_the_speed_limit_ahead_counts_what_the_obstacle_moves() -> None:
    standing, fleeing, coming = (scene_of([(3.0, 0.0, 1.0, v, 0.0)]) for v in (0.0, 1.0, -9.0))
    assert speed_limit_ahead_m_s(standing, 0.0, 0.0, 1.0, 0.0, 4.0, 0.0) == pytest.approx(4.0)
    assert speed_limit_ahead_m_s(fleeing, 0.0, 0.0, 1.0, 0.0, 4.0, 0.0) == pytest.approx(5.0)
    assert speed_limit_ahead_m_s(coming, 0.0, 0.0, 1.0, 0.0, 4.0, 0.0) == 0.0
    assert speed_limit_ahead_m_s(standing, 0.0, 0.0, -1.0, 0.0, 4.0, 0.0) == math.inf


@pytest.mark.parametrize("avoidance", ["search", "field"])
def test_teammates_are_avoided_but_only_the_plain_field_is_repelled_by_them(avoidance: str) -> None:
    beside = scene_of([(1.0, 2.0, 0.5, 0.0, 0.0)])
    moment = Moment(Ac2fParameters(avoidance=avoidance), beside, (2.0, 0.0), vehicles=1)
    action = moment.react((2.0, 0.0))
    assert (action["velocity_e"] < -0.01) == (avoidance == "field")
    ahead = scene_of([(1.0, 0.0, 0.5, 0.0, 0.0)])
    assert Moment(Ac2fParameters(avoidance=avoidance), ahead, (2.0, 0.0), vehicles=1).react((2.0, 0.0))["velocity_n"] < 1.6


@given(SEEDS, st.floats(0.0, 5.0), st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.sampled_from(["search", "field"]))
def test_a_command_is_reached_within_a_period_and_inside_the_limits(
    seed: int, speed: float, wish_n: float, wish_e: float, avoidance: str
) -> None:
    scene = random_scene(np.random.default_rng(seed), 10)
    action = Moment(Ac2fParameters(avoidance=avoidance), scene, (speed, 0.0)).react((wish_n, wish_e))
    assert math.hypot(action["velocity_n"], action["velocity_e"]) <= limits().speed_max_m_s + 1e-9
    change = math.hypot(action["velocity_n"] - speed, action["velocity_e"])
    assert change <= limits().acceleration_max_m_s2 * PARAMETERS.control_period_s + 1e-9


def yaw(base: Pair, wish: Pair, watched: Pair | None) -> float:
    return float(Moment(PARAMETERS, scene_of([]), base, nose_rad=1.25).react(wish, watched=watched)["yaw_rad"])


def test_where_the_nose_points() -> None:
    assert yaw((3.0, 0.0), (0.0, 3.0), (-5.0, 0.0)) == pytest.approx(math.pi / 2)
    assert yaw((0.0, 0.0), (0.0, 0.0), (-5.0, 0.0)) == pytest.approx(math.pi)
    assert yaw((0.0, 0.0), (0.0, 0.0), (-15.0, 0.0)) == 1.25
    assert yaw((0.0, 0.0), (0.0, 0.0), None) == 1.25


def test_slow_into_an_unseen_sector() -> None:
    unseen = np.array([[3.0, -3.0], [0.5, 1.0]])
    assert seen_share(3.0, 0.0, unseen, 1.5) == 1.0
    assert seen_share(-3.0, 0.0, unseen, 1.5) == 0.5
    assert seen_share(3.0 * math.cos(0.7), 3.0 * math.sin(0.7), unseen, 1.5) == pytest.approx(0.5)
    assert seen_share(-1.0, 0.0, unseen, 1.5) == 1.0
    assert seen_share(3.0, 0.0, np.array([[1.0, 1.0 + 2.0 * math.pi]]), 1.5) == 0.5
    action = Moment(PARAMETERS, scene_of([]), (-1.5, 0.0)).react((-5.0, 0.0), unseen=unseen)
    assert action["velocity_n"] == pytest.approx(-1.5)


def test_hold_brakes_and_gives_way() -> None:
    braking = Moment(PARAMETERS, scene_of([]), (3.0, 0.0), nose_rad=0.5).hold()
    assert (braking["velocity_n"], braking["yaw_rad"], braking["has_goal"]) == (pytest.approx(2.5), 0.5, 0)
    pressed = Moment(PARAMETERS, scene_of([(1.5, 0.0, 1.0, -3.0, 0.0)])).hold()
    assert math.hypot(pressed["velocity_n"], pressed["velocity_e"]) > 0.1


def test_search_flies_to_the_place_and_turns_there() -> None:
    flying = Moment(PARAMETERS, scene_of([]), (3.0, 0.0), own_yaw_rad=1.0).search((4.0, 0.0), (9.0, 0.0))
    assert (flying["yaw_rad"], flying["goal_n"]) == (pytest.approx(0.0), 9.0)
    there = Moment(PARAMETERS, scene_of([]), own_yaw_rad=1.0).search((0.0, 0.0), (0.0, 0.0))
    assert there["yaw_rad"] == pytest.approx(1.0 + PARAMETERS.search_turn_rad)
