"""The forces of the adaptive field as the avoidance of AC2F's coarse stage."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, Boundary, Limits, Observation, ObstacleSet, TargetTrack, VehicleState
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.api import Planner
from flightapp.planning.registry import make_planner

LIMITS = Limits(6.0, 6.0, 30.0, 3.0, 12.0, 3.0, 0.25, 0.25)
EDGE = Boundary(np.array(((0.0, -50.0), (0.0, 50.0))), closed=False)
TARGET = np.array((40.0, 0.0, -3.0))
PERIOD_S = 0.1


def planner(avoidance: str) -> Planner:
    parameters = {"reaction_s": 0.1, "response_lag_s": 0.0, "command_blend": 1.0, "avoidance": avoidance}
    return make_planner("ac2f", limits=LIMITS, parameters=parameters)


def flown(avoidance: str, discs: Array, seconds: float) -> tuple[Array, Array, set[str]]:
    """Places, velocities and modes of a vehicle that flies every velocity at once."""
    strategy, place, velocity = planner(avoidance), np.array((5.0, 0.0, -3.0)), np.zeros(3)
    places, velocities, modes = [place], [velocity], set()
    for k in range(round(seconds / PERIOD_S)):
        t_s = k * PERIOD_S
        track = TargetTrack(t_s, TARGET, np.zeros(3), np.eye(6), 0.0)
        own = VehicleState(t_s, place, velocity, 0.0)
        decision = strategy.step(Observation(t_s, PERIOD_S, own, (), track, ObstacleSet(t_s, discs, np.zeros((0, 2))), EDGE))
        velocity = decision.velocity_ned_m_s
        place = place + PERIOD_S * velocity
        places.append(place)
        velocities.append(velocity)
        modes.add(decision.mode)
    return np.array(places), np.array(velocities), modes


def test_the_forces_lead_the_coarse_stage_around_an_obstacle_without_slowing_it() -> None:
    one = np.array([[16.0, 0.3, 1.0, 0.0, 0.0, -math.inf, math.inf]])
    places, velocities, modes = flown("adaptive", one, 4.0)
    default, _, _ = flown("search", one, 4.0)
    assert modes == {"coarse"}
    assert np.hypot(places[:, 0] - 16.0, places[:, 1] - 0.3).min() > 1.0 + LIMITS.body_radius_m + LIMITS.safety_margin_m - 0.05
    assert places[-1, 0] > 22.0
    assert np.linalg.norm(velocities[15:], axis=1).min() > 5.0
    assert np.abs(places - default).max() > 0.1  # it is the forces that lead


def test_without_obstacles_both_fly_the_same_and_the_default_is_the_search() -> None:
    np.testing.assert_array_equal(flown("adaptive", np.zeros((0, 7)), 1.0)[0], flown("search", np.zeros((0, 7)), 1.0)[0])
    assert Ac2fParameters().avoidance == "search"
