from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.types import Array, Limits, VehicleState
from flightapp.planning.path_planning.smoothing import rounded
from flightapp.planning.path_planning.trajectory import FlightLimits, timed
from flightapp.runtime.way_follower import STALLED_S, STOPPED_M, WayFollower
from flightapp.space.world import World

LIMITS = Limits(5.0, 5.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45)
CORNERS = np.array([[0.0, 0.0, -5.0], [20.0, 0.0, -5.0], [20.0, 15.0, -8.0]])
WAY = timed(rounded(World.of([]), CORNERS, 1.0)[0], FlightLimits(4.0, 1.5, 5.0))
PERIOD_S = 0.05


def state(t_s: float, place: Array) -> VehicleState:
    return VehicleState(t_s, place, np.zeros(3), 0.0)


def follow(
    follower: WayFollower, held_s: tuple[float, float] = (math.inf, math.inf), until_s: float = 60.0
) -> tuple[float, Array]:
    """A vehicle with a lag of 0.3 s follows, except while it is held; returns when it arrived or stalled, and where."""
    place, velocity, t_s = np.array((0.0, 0.0, -5.0)), np.zeros(3), 0.0
    while t_s < until_s and not (follower.arrived or follower.failure):
        asked = follower.setpoint(state(t_s, place), t_s, 0.0)
        assert math.hypot(*asked.velocity_ned_m_s[:2]) <= LIMITS.speed_max_m_s + 1e-9
        assert abs(asked.velocity_ned_m_s[2]) <= LIMITS.climb_rate_max_m_s + 1e-9
        held = held_s[0] <= t_s < held_s[1]
        velocity = np.zeros(3) if held else velocity + (1.0 - math.exp(-PERIOD_S / 0.3)) * (asked.velocity_ned_m_s - velocity)
        place = place + PERIOD_S * velocity
        nearest = min(float(np.linalg.norm(WAY.positions_ned_m - place, axis=1).min()), math.inf)
        assert nearest < 0.5, "it left the way"
        t_s += PERIOD_S
    return t_s, place


def test_it_arrives_about_when_the_way_says() -> None:
    follower = WayFollower(WAY, LIMITS, feed_forward=False)
    t_s, place = follow(follower)
    assert follower.arrived
    assert math.dist(place, (20.0, 15.0, -8.0)) < 1.0
    assert t_s == pytest.approx(WAY.duration_s, abs=1.0)


def test_a_vehicle_that_is_held_up_is_waited_for_and_stays_on_its_way() -> None:
    follower = WayFollower(WAY, LIMITS, feed_forward=False)
    t_s, _ = follow(follower, held_s=(2.0, 7.0))
    assert follower.arrived
    assert t_s == pytest.approx(WAY.duration_s + 5.0, abs=2.0)


def test_a_vehicle_that_is_held_up_for_long_is_told_from_one_that_flies() -> None:
    follower = WayFollower(WAY, LIMITS, feed_forward=True)
    t_s, place = follow(follower, held_s=(2.0, math.inf))
    assert follower.failure.startswith("no progress for 8 s")
    assert not follower.arrived
    assert 2.0 + STALLED_S <= t_s < 2.0 + STALLED_S + 5.0
    asked = follower.setpoint(state(t_s, place), t_s, 0.0)
    assert float(np.linalg.norm(asked.velocity_ned_m_s)) <= STOPPED_M


def test_it_looks_where_it_flies() -> None:
    follower = WayFollower(WAY, LIMITS, feed_forward=True)
    follower.setpoint(state(0.0, WAY.positions_ned_m[0]), 0.0, 1.0)
    for k in range(1, 40):
        moment = WAY.at(k * PERIOD_S)
        asked = follower.setpoint(state(k * PERIOD_S, moment.position_ned_m), k * PERIOD_S, 1.0)
    assert asked.yaw_rad == pytest.approx(0.0, abs=0.01)
    assert asked.acceleration_ned_m_s2 is not None


def test_who_creeps_along_the_way_is_given_up_on_and_who_is_made_to_wait_is_not() -> None:
    creeping, waiting = (WayFollower(WAY, LIMITS, feed_forward=False) for _ in range(2))
    place, t_s = np.array((0.0, 0.0, -5.0)), 0.0
    while not (creeping.failure or creeping.arrived):
        place = place + PERIOD_S * 0.1 * creeping.setpoint(state(t_s, place), t_s, 0.0).velocity_ned_m_s
        t_s += PERIOD_S
    assert creeping.failure.startswith("not there after ")
    assert t_s == pytest.approx(creeping.time_limit_s, abs=0.2)
    for k in range(20):
        waiting.setpoint(state(30.0 * k, place), 30.0 * k, 0.0)
        waiting.pause()
    assert not waiting.failure
