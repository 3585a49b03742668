"""The vehicle model: limits, determinism, wind, ground."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.sim.multirotor import Command, Multirotor, MultirotorLimits, Wind

DT_S = 0.005
LIMITS = MultirotorLimits(
    speed_max_m_s=6.0,
    climb_rate_max_m_s=2.5,
    descent_rate_max_m_s=2.0,
    acceleration_max_m_s2=6.0,
    jerk_max_m_s3=50.0,
    yaw_rate_max_rad_s=3.0,
    yaw_acceleration_max_rad_s2=12.0,
)
speeds = st.floats(-30.0, 30.0)
commands = st.lists(st.tuples(speeds, speeds, speeds, st.floats(-4.0, 4.0), st.integers(10, 200)), min_size=1, max_size=6)


def flying(seed: int = 0, wind: Wind | None = None, height_m: float = 100.0) -> Multirotor:
    vehicle = Multirotor(LIMITS, position_ned_m=(0.0, 0.0, -height_m), ground_down_m=0.0, wind=wind, seed=seed)
    vehicle.motors.running = True
    return vehicle


def run(vehicle: Multirotor, command: Command, duration_s: float) -> None:
    for _ in range(round(duration_s / DT_S)):
        vehicle.step(DT_S, command)


@settings(max_examples=40, deadline=None)
@given(commands)
def test_limits_are_never_exceeded(legs: list[tuple[float, float, float, float, int]]) -> None:
    vehicle = flying()
    # The frame still moves with its old tilt for one response time after a command changes.
    overshoot = LIMITS.acceleration_max_m_s2 * LIMITS.response_s
    for north, east, down, yaw, steps in legs:
        command = Command((north, east, down), yaw_rad=yaw)
        for _ in range(steps):
            acceleration, rate = vehicle.acceleration_ned_m_s2, vehicle.yaw_rate_rad_s
            vehicle.step(DT_S, command)
            change = math.dist(vehicle.acceleration_ned_m_s2, acceleration)
            velocity = vehicle.velocity_ned_m_s
            assert math.hypot(*vehicle.acceleration_ned_m_s2) <= LIMITS.acceleration_max_m_s2 + 1e-9
            assert change <= LIMITS.jerk_max_m_s3 * DT_S + 1e-9
            assert abs(vehicle.yaw_rate_rad_s) <= LIMITS.yaw_rate_max_rad_s + 1e-9
            assert abs(vehicle.yaw_rate_rad_s - rate) <= LIMITS.yaw_acceleration_max_rad_s2 * DT_S + 1e-9
            assert math.hypot(velocity[0], velocity[1]) <= LIMITS.speed_max_m_s + overshoot
            assert -LIMITS.climb_rate_max_m_s - overshoot <= velocity[2] <= LIMITS.descent_rate_max_m_s + overshoot


@settings(max_examples=10, deadline=None)
@given(commands, st.integers(0, 1000))
def test_the_same_seed_gives_the_same_flight_bit_for_bit(legs: list[tuple[float, float, float, float, int]], seed: int) -> None:
    ends = []
    for _ in range(2):
        vehicle = flying(seed, Wind(2.0, -1.0, 1.5))
        for north, east, down, yaw, steps in legs:
            run(vehicle, Command((north, east, down), yaw_rad=yaw), steps * DT_S)
        ends.append((vehicle.position_ned_m, vehicle.velocity_ned_m_s, vehicle.yaw_rad, vehicle.roll_rad))
    assert ends[0] == ends[1]


def test_a_velocity_command_is_reached_without_overshoot() -> None:
    vehicle = flying()
    top = 0.0
    for _ in range(800):
        vehicle.step(DT_S, Command((3.0, 0.0, 0.0), yaw_rad=0.0))
        top = max(top, vehicle.velocity_ned_m_s[0])
    assert vehicle.velocity_ned_m_s[0] == pytest.approx(3.0, abs=0.02)
    assert top < 3.02


def test_accelerating_north_pitches_the_nose_down_and_east_rolls_right() -> None:
    vehicle = flying()
    run(vehicle, Command((5.0, 0.0, 0.0), yaw_rad=0.0), 0.3)
    assert vehicle.pitch_rad < -0.1
    vehicle = flying()
    run(vehicle, Command((0.0, 5.0, 0.0), yaw_rad=0.0), 0.3)
    assert vehicle.roll_rad > 0.1


def test_wind_is_rejected_but_not_at_once() -> None:
    vehicle = flying(wind=Wind(north_m_s=6.0))
    run(vehicle, Command((0.0, 0.0, 0.0), yaw_rad=0.0), 0.5)
    pushed = vehicle.velocity_ned_m_s[0]
    run(vehicle, Command((0.0, 0.0, 0.0), yaw_rad=0.0), 6.0)
    assert pushed > 0.15
    assert abs(vehicle.velocity_ned_m_s[0]) < 0.05


def test_gusts_move_the_vehicle_within_reason() -> None:
    vehicle = flying(seed=3, wind=Wind(gust_m_s=2.0))
    worst = 0.0
    for _ in range(4000):
        vehicle.step(DT_S, Command((0.0, 0.0, 0.0), yaw_rad=0.0))
        worst = max(worst, math.hypot(*vehicle.velocity_ned_m_s))
    assert 0.05 < worst < 1.5


def test_a_falling_vehicle_stops_at_the_ground() -> None:
    vehicle = flying(height_m=3.0)
    vehicle.motors.running = False
    run(vehicle, Command(), 2.0)
    assert vehicle.on_ground
    assert vehicle.position_ned_m[2] == 0.0
    assert vehicle.velocity_ned_m_s == (0.0, 0.0, 0.0)
    assert vehicle.impact_speed_m_s == pytest.approx(math.sqrt(2 * 9.80665 * 3.0), rel=0.3)


def test_it_stays_on_the_ground_until_it_shall_climb() -> None:
    vehicle = flying(height_m=0.0)
    run(vehicle, Command((0.0, 0.0, 0.0), yaw_rad=1.0), 1.0)
    assert vehicle.on_ground
    run(vehicle, Command((0.0, 0.0, -1.0), yaw_rad=1.0), 2.0)
    assert vehicle.height_above_ground_m > 1.0


def test_too_little_thrust_sinks() -> None:
    vehicle = flying()
    vehicle.motors.thrust_available = 0.3
    run(vehicle, Command((0.0, 0.0, 0.0), yaw_rad=0.0), 2.0)
    assert vehicle.thrust_short
    assert vehicle.velocity_ned_m_s[2] > 1.0
