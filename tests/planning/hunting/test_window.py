"""The widened window: what it commands can be flown, and leaves room to stop."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Limits
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.hunting.planner import motion_record
from flightapp.planning.hunting.window import STATE, all_rays_hit, can_brake, choose

LIMITS = Limits(6.0, 6.0, 60.0, 3.0, 12.0, 2.0, 0.25, 0.25)
PARAMETERS = HuntingParameters(reaction_s=0.1)
COUNT = (PARAMETERS.speed_samples + 2) * (PARAMETERS.turn_samples + 3)
PERIOD_S = PARAMETERS.control_period_s
discs = st.lists(st.tuples(st.floats(-15, 15), st.floats(-15, 15), st.floats(0.3, 2.0)), max_size=6)


def chosen(
    scene: list[tuple[float, float, float]], speed: float, turn: float, aim: tuple[float, float], beyond: bool = False
) -> np.void:
    rows = np.array([(a, b, c, 0.0, 0.0, 0.0) for a, b, c in scene]).reshape(-1, 6)
    state = np.zeros(1, STATE)
    state["speed"], state["turn"] = speed, turn
    state["aim_n"], state["aim_e"], state["wanted_speed"] = *aim, 6.0
    room = np.zeros((max(1, len(rows)), 5))
    motion = motion_record(PARAMETERS.model_copy(update={"free_way_beyond_horizon": beyond}), LIMITS)
    choose(
        motion, state, rows, PARAMETERS.steps, PARAMETERS.speed_samples, PARAMETERS.turn_samples, room,
        np.zeros(COUNT), np.zeros(COUNT), np.zeros((7, COUNT)), np.zeros((4, COUNT)), np.zeros(COUNT), np.zeros(COUNT, np.int64),
    )  # fmt: skip
    return state[0]


@settings(max_examples=25, deadline=None)
@given(discs, st.floats(0.0, 6.0), st.floats(-1.0, 1.0), st.floats(-50, 50), st.floats(-50, 50))
def test_every_command_is_within_the_limits_of_one_control_period(
    scene: list[tuple[float, float, float]], speed: float, turn: float, aim_n: float, aim_e: float
) -> None:
    got = chosen(scene, speed, turn, (aim_n, aim_e))
    assert abs(got["first_speed"] - speed) <= 6.0 * PERIOD_S + 1e-9
    assert abs(got["first_turn"] - turn) <= 12.0 * PERIOD_S + 1e-9
    assert 0.0 <= got["first_speed"] <= 6.0


@settings(max_examples=15, deadline=None)
@given(discs, st.floats(0, 3))
def test_a_vehicle_that_starts_free_never_touches_a_standing_disc(scene: list[tuple[float, float, float]], turn: float) -> None:
    free = [(n, e, r) for n, e, r in scene if math.hypot(n, e) > r + 0.3]
    n = e = course = speed = rate = 0.0
    for _ in range(40):
        cos, sin = math.cos(course), math.sin(course)
        seen = [((a - n) * cos + (b - e) * sin, (b - e) * cos - (a - n) * sin, r) for a, b, r in free]
        aim = (30.0 * math.cos(turn) - n, 30.0 * math.sin(turn) - e)
        got = chosen(seen, speed, rate, (aim[0] * cos + aim[1] * sin, aim[1] * cos - aim[0] * sin))
        speed, rate = float(got["first_speed"]), float(got["first_turn"])
        bend = rate * PERIOD_S
        n += speed * PERIOD_S * math.cos(course + 0.5 * bend)
        e += speed * PERIOD_S * math.sin(course + 0.5 * bend)
        course += bend
        assert all(math.hypot(a - n, b - e) > r - 0.02 for a, b, r in free)


def brakes_free(n: float, e: float, course: float, speed: float, rate: float, discs: list[tuple[float, float, float]]) -> bool:
    """Braking at once and ending the turn, whether no disc is touched. In steps of 5 ms, not by the planner's arithmetic."""
    dt = 0.005
    while speed > 0.0:
        if any(math.hypot(a - n, b - e) < r - 0.02 for a, b, r in discs):
            return False
        speed = max(0.0, speed - LIMITS.acceleration_max_m_s2 * PARAMETERS.braking_share * dt)
        rate = math.copysign(max(0.0, abs(rate) - LIMITS.yaw_acceleration_max_rad_s2 * dt), rate)
        n, e, course = n + speed * math.cos(course) * dt, e + speed * math.sin(course) * dt, course + rate * dt
    return True


@settings(max_examples=12, deadline=None)
@given(discs, st.floats(0, 3))
def test_from_every_commanded_state_it_can_brake_without_touching_anything(
    scene: list[tuple[float, float, float]], turn: float
) -> None:
    free = [(n, e, r) for n, e, r in scene if math.hypot(n, e) > r + 0.3]
    n = e = course = speed = rate = 0.0
    for _ in range(30):
        cos, sin = math.cos(course), math.sin(course)
        seen = [((a - n) * cos + (b - e) * sin, (b - e) * cos - (a - n) * sin, r) for a, b, r in free]
        aim = (30.0 * math.cos(turn) - n, 30.0 * math.sin(turn) - e)
        got = chosen(seen, speed, rate, (aim[0] * cos + aim[1] * sin, aim[1] * cos - aim[0] * sin))
        speed, rate = float(got["first_speed"]), float(got["first_turn"])
        bend = rate * PERIOD_S
        n += speed * PERIOD_S * math.cos(course + 0.5 * bend)
        e += speed * PERIOD_S * math.sin(course + 0.5 * bend)
        course += bend
        assert brakes_free(n, e, course, speed, rate, free)


@settings(max_examples=20, deadline=None)
@given(discs, st.floats(0.5, 6.0), st.floats(0.05, 1.0), st.floats(-50, 50), st.floats(2, 50))
def test_a_mirrored_scene_gives_the_mirrored_command(
    scene: list[tuple[float, float, float]], speed: float, turn: float, aim_n: float, aim_e: float
) -> None:
    """Nothing of the scene is in line with the course: what is as good on the left as on the right may go either way."""
    left = chosen(scene, speed, turn, (aim_n, aim_e))
    right = chosen([(n, -e, r) for n, e, r in scene], speed, -turn, (aim_n, -aim_e))
    assert left["first_speed"] == pytest.approx(right["first_speed"], abs=1e-9)
    assert left["first_turn"] == pytest.approx(-right["first_turn"], abs=1e-9)


def test_in_front_of_a_wall_it_stops_and_nothing_faster_counts() -> None:
    wall = [(3.5, float(e), 1.0) for e in range(-8, 9)]
    got = chosen(wall, 4.5, 0.0, (30.0, 0.0))
    assert got["collisions"] > 0
    assert got["first_speed"] < 4.5
    rows = np.array([(n, e, r, 0.0, 0.0) for n, e, r in wall])
    state = np.zeros(1, STATE)
    assert not can_brake(motion_record(PARAMETERS, LIMITS), state, rows, len(rows), 6.0, 0.0)
    assert can_brake(motion_record(PARAMETERS, LIMITS), state, rows, len(rows), 2.0, 0.0)


def test_the_fan_is_hit_by_a_wall_but_not_where_a_gap_or_the_goal_is_nearer() -> None:
    wall = np.array([(5.0, float(e), 1.0, 0.0, 0.0, 0.0) for e in range(-8, 9)])
    half = math.radians(30.0)
    assert all_rays_hit(wall, 0.0, 0.0, 0.0, half, 8.0, 99.0)
    assert not all_rays_hit(wall, 0.0, 0.0, 0.0, half, 8.0, 3.0)
    assert not all_rays_hit(wall[:8], 0.0, 0.0, 0.0, half, 8.0, 99.0)
    assert not all_rays_hit(wall, 0.0, 0.0, math.pi, half, 8.0, 99.0)


def test_who_creeps_up_to_a_wall_is_not_free_of_it_where_the_way_beyond_the_horizon_counts() -> None:
    """Within its horizon a slow sample touches nothing, however near the wall is."""
    wall = [(3.0, float(e), 1.0) for e in range(-3, 4)]
    plain, beyond = (chosen(wall, 0.3, 0.0, (30.0, 0.0), beyond=on) for on in (False, True))
    assert plain["free_m"] > 8.0
    assert beyond["free_m"] < 2.0
