"""The compiled vehicles against plain arcs and against the multirotor of the application's simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
from flightapp.sim.batch.families.layout import Start
from flightapp.sim.multirotor import Command, Multirotor, MultirotorLimits, Wind
from tests.sim.batch.stubs import command, scenario, set_moving, world

UNICYCLE = scenario(pursuers__count=1)
MULTIROTOR = scenario("a2-encircle", pursuers__count=1, pursuers__delay_s=0.0)
FAR_AWAY = Start(90.0, 90.0, 0.0)
PERIOD_S = 0.1


@settings(max_examples=60, deadline=None)
@given(st.floats(0.5, 6.0), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-math.pi, math.pi))
def test_unicycle_flies_an_arc_of_the_dynamic_window_exactly(
    speed: float, turn: float, more_speed: float, more_turn: float, course: float
) -> None:
    """Any (v, omega) within one period's reach, commanded as the velocity at the arc's end, as the planner does."""
    new_speed = min(6.0, max(0.06, speed + more_speed * 6.0 * PERIOD_S))
    new_turn = min(3.0, max(-3.0, turn + more_turn * 12.0 * PERIOD_S))
    flown = world(UNICYCLE, [Start(1.0, 2.0, course)], FAR_AWAY, [])
    set_moving(flown, 0, speed * math.cos(course), speed * math.sin(course))
    flown.vehicles[0]["yaw_rate"] = turn
    end = course + new_turn * PERIOD_S
    flown.advance(0, [command(new_speed * math.cos(end), new_speed * math.sin(end)), command(0.0, 0.0)])
    steps = 20_000
    headings = course + new_turn * PERIOD_S * (np.arange(steps) + 0.5) / steps
    reference = np.array([1.0, 2.0]) + new_speed * PERIOD_S * np.array([np.cos(headings).mean(), np.sin(headings).mean()])
    state = flown.states(0.0)[0]
    np.testing.assert_allclose(state.position_ned_m[:2], reference, atol=1e-8)
    assert abs(wrap_pi(state.yaw_rad - end)) < 1e-9
    assert math.hypot(*state.velocity_ned_m_s[:2]) == pytest.approx(new_speed, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(-math.pi, math.pi), st.floats(0.0, 6.0))
def test_unicycle_keeps_its_limits_whatever_is_commanded_and_never_flies_backwards(
    north: float, east: float, course: float, speed: float
) -> None:
    flown = world(UNICYCLE, [Start(0.0, 0.0, course)], FAR_AWAY, [])
    set_moving(flown, 0, speed * math.cos(course), speed * math.sin(course))
    turn, before = 0.0, flown.states(0.0)[0]
    for tick in range(30):
        flown.advance(tick, [command(north, east), command(0.0, 0.0)])
        vehicle, state = flown.vehicles[0], flown.states(0.0)[0]
        moved = state.position_ned_m - before.position_ned_m
        assert moved[0] * math.cos(before.yaw_rad) + moved[1] * math.sin(before.yaw_rad) >= -1e-9
        assert 0.0 <= vehicle["speed"] <= 6.0
        assert abs(float(vehicle["speed"]) - speed) <= 0.6 + 1e-9
        assert abs(float(vehicle["yaw_rate"])) <= 3.0 + 1e-9
        assert abs(float(vehicle["yaw_rate"]) - turn) <= 1.2 + 1e-9
        speed, turn, before = float(vehicle["speed"]), float(vehicle["yaw_rate"]), state
    wanted = min(6.0, math.hypot(north, east))
    if wanted > 0.1:
        assert speed == pytest.approx(wanted, abs=0.05)
        assert abs(wrap_pi(before.yaw_rad - math.atan2(east, north))) < 0.05


def test_unicycle_that_is_told_to_turn_round_slows_down_first() -> None:
    flown = world(UNICYCLE, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [])
    set_moving(flown, 0, 4.0, 0.0)
    speeds = []
    for tick in range(25):
        flown.advance(tick, [command(-4.0, 0.0), command(0.0, 0.0)])
        speeds.append(float(flown.vehicles[0]["speed"]))
    assert min(speeds) < 1.5
    assert speeds[-1] == pytest.approx(4.0)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), st.floats(-3.0, 3.0)), min_size=3, max_size=6),
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
)
def test_multirotor_flies_as_the_one_of_the_whole_simulation(
    commands: list[tuple[float, float, float]], wind_n: float, wind_e: float
) -> None:
    windy = scenario("a2-encircle", pursuers__count=1, pursuers__delay_s=0.0, wind__north_m_s=wind_n, wind__east_m_s=wind_e)
    flown = world(windy, [Start(3.0, -4.0, 0.5)], FAR_AWAY, [])
    limits = MultirotorLimits(
        speed_max_m_s=6.0,
        acceleration_max_m_s2=7.8,
        jerk_max_m_s3=78.0,
        yaw_rate_max_rad_s=3.0,
        yaw_acceleration_max_rad_s2=12.0,
    )
    reference = Multirotor(
        limits, position_ned_m=(3.0, -4.0, -5.0), yaw_rad=0.5, wind=Wind(wind_n, wind_e), ground_down_m=0.0, seed=1
    )
    reference.motors.running = True
    for tick, (north, east, yaw) in enumerate(commands):
        flown.advance(tick, [command(north, east, yaw), command(0.0, 0.0)])
        for _ in range(5):
            reference.step(0.02, Command((north, east, 0.0), yaw_rad=yaw))
        state = flown.states(0.0)[0]
        np.testing.assert_allclose(state.position_ned_m[:2], reference.position_ned_m[:2], atol=1e-9)
        np.testing.assert_allclose(state.velocity_ned_m_s[:2], reference.velocity_ned_m_s[:2], atol=1e-9)
        assert abs(wrap_pi(state.yaw_rad - reference.yaw_rad)) < 1e-9


def test_command_delay_shifts_the_flight_by_just_that() -> None:
    late = scenario("a2-encircle", pursuers__count=1, pursuers__delay_s=0.06)
    prompt = world(MULTIROTOR, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [])
    delayed = world(late, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [])
    starts = []
    for flown in (prompt, delayed):
        path = []
        for tick in range(4):
            flown.advance(tick, [command(5.0, 0.0), command(0.0, 0.0)])
            path.append(flown.states(0.0)[0].position_ned_m[0])
        starts.append(path)
    still = world(late, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [])
    still.record["sub_steps"] = 3
    still.advance(0, [command(5.0, 0.0), command(0.0, 0.0)])
    assert still.states(0.0)[0].position_ned_m[0] == 0.0
    assert 0.0 < starts[1][0] < 0.2 * starts[0][0]
    assert starts[1][3] < starts[0][3]


def test_gusts_push_and_repeat() -> None:
    gusty = scenario("a2-encircle", pursuers__count=1, wind__gust_m_s=2.0)
    ends = []
    for _ in range(2):
        flown = world(gusty, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [])
        for tick in range(50):
            flown.advance(tick, [command(0.0, 0.0, 0.0), command(0.0, 0.0)])
        ends.append(flown.states(0.0)[0].position_ned_m)
    assert np.hypot(ends[0][0], ends[0][1]) > 0.02
    assert (ends[0] == ends[1]).all()
