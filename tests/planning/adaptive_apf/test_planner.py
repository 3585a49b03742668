"""What a pursuer under `adaptive-apf` does with observations, sound and unsound."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.core.types import Array, Boundary, Decision, Limits, Observation, ObstacleSet, TargetTrack, VehicleState
from flightapp.planning.api import Planner
from flightapp.planning.registry import make_planner
from flightapp.space.shapes import bodies_of_discs
from flightapp.space.world import World

LIMITS = Limits(6.0, 6.0, 30.0, 3.0, 12.0, 3.0, 0.25, 0.25)
EDGE = Boundary(np.array(((0.0, -50.0), (0.0, 50.0))), closed=False)
IDEAL = {"reaction_s": 0.1, "response_lag_s": 0.0, "command_blend": 1.0}
PERIOD_S = 0.1


def planner(name: str = "adaptive-apf", **changed: object) -> Planner:
    return make_planner(name, limits=LIMITS, parameters={**IDEAL, **changed}, seed=3)


def seen(
    t_s: float, place: Array, velocity: Array, target: Array, discs: Array, target_velocity: Array | None = None
) -> Observation:
    own = VehicleState(t_s, place, velocity, 0.0)
    moving = np.zeros(3) if target_velocity is None else target_velocity
    track = TargetTrack(t_s, target, moving, np.eye(6), 0.0)
    return Observation(t_s, PERIOD_S, own, (), track, ObstacleSet(t_s, discs, np.zeros((0, 2))), EDGE)


def disc(north: float, east: float, radius: float, top: float = -math.inf, bottom: float = math.inf) -> list[float]:
    return [north, east, radius, 0.0, 0.0, top, bottom]


def flown(strategy: Planner, start: Array, target: Array, discs: Array, seconds: float) -> tuple[Array, list[Decision]]:
    """Places and decisions of a vehicle that flies every velocity at once, until it is 0.4 m from the target."""
    place, velocity, places, decisions = start, np.zeros(3), [start], []
    for k in range(round(seconds / PERIOD_S)):
        decision = strategy.step(seen(k * PERIOD_S, place, velocity, target, discs))
        velocity = decision.velocity_ned_m_s
        place = place + PERIOD_S * velocity
        places.append(place)
        decisions.append(decision)
        if np.linalg.norm(place - target) < 0.4:
            break
    return np.array(places), decisions


def test_it_flies_over_an_obstacle_whose_height_is_known_and_around_one_whose_height_is_not() -> None:
    target = np.array((20.0, 0.0, -6.0))
    low = np.array([disc(10.0, 0.1, 2.0, -4.0, 0.0)])
    over, _ = flown(planner(), np.array((0.0, 0.0, -3.0)), target, low, 10.0)
    assert np.linalg.norm(over[-1] - target) < 0.4
    assert World.of_bodies(bodies_of_discs(low)).signed_distance_m(over[len(over) // 2]) > 0.25
    high = np.array([disc(10.0, 0.1, 2.0)])
    around, _ = flown(planner(), np.array((0.0, 0.0, -3.0)), target, high, 10.0)
    assert np.abs(around[:, 2] + 3.0).max() == 0.0  # it holds its height
    assert np.hypot(around[:, 0] - 10.0, around[:, 1] - 0.1).min() > 2.25
    assert math.dist(around[-1][:2], target[:2]) < 0.6


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**31))
def test_it_reaches_a_target_past_single_obstacles(seed: int) -> None:
    generator = np.random.default_rng(seed)
    target = np.array((25.0, 0.0, -3.0))
    one = disc(float(generator.uniform(7.0, 18.0)), float(generator.uniform(-3.0, 3.0)), float(generator.uniform(0.3, 2.0)))
    places, _ = flown(planner(), np.array((0.0, 0.0, -3.0)), target, np.array([one]), 15.0)
    assert np.linalg.norm(places[-1] - target) < 0.4
    assert np.hypot(places[:, 0] - one[0], places[:, 1] - one[1]).min() > one[2] + 0.25


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from(["adaptive-apf", "conventional-apf", "iapf-style"]))
def test_commands_are_finite_and_within_the_limits_whatever_is_seen(seed: int, name: str) -> None:
    generator = np.random.default_rng(seed)
    strategy = planner(name)
    velocity = np.zeros(3)
    for k in range(6):
        discs = np.zeros((5, 7))
        discs[:, :2] = generator.integers(-2, 3, (5, 2))
        discs[:, 2] = generator.choice((0.0, 0.5, 1.0), 5)
        discs[:, 3:5] = generator.choice((0.0, 2.0, -50.0), (5, 2))
        discs[:, 5], discs[:, 6] = generator.choice((-math.inf, -5.0), 5), generator.choice((math.inf, 1.0), 5)
        discs[generator.integers(5), generator.integers(5)] = generator.choice((math.nan, 0.0, math.inf))
        place, target = generator.integers(-2, 3, (2, 3)).astype(np.float64)
        decision = strategy.step(seen(PERIOD_S * k, place, velocity, target, discs, generator.integers(-3, 4, 3) * 1.0))
        command = decision.velocity_ned_m_s
        assert np.isfinite(command).all()
        assert np.isfinite(decision.yaw_rad)
        assert np.linalg.norm(command) <= LIMITS.speed_max_m_s + 1e-9
        assert np.linalg.norm(command - velocity) <= LIMITS.acceleration_max_m_s2 * PERIOD_S + 1e-9
        velocity = command


def test_a_trapped_vehicle_escapes_with_module_b_only_and_the_same_way_every_time() -> None:
    target = np.array((20.0, 0.0, -3.0))
    trap = np.array([disc(8.0, east, 0.6) for east in (-1.2, 0.0, 1.2)])
    start = np.array((0.0, 0.0, -3.0))
    without, stuck = flown(planner(modules="A"), start, target, trap, 12.0)
    one, decisions = flown(planner(modules="AB"), start, target, trap, 25.0)
    two, _ = flown(planner(modules="AB"), start, target, trap, 25.0)
    assert math.dist(without[-1], target) > 10.0
    assert {decision.mode for decision in stuck} == {"pursue"}
    assert "escape" in {decision.mode for decision in decisions}
    assert math.dist(one[-1], target) < 0.4
    np.testing.assert_array_equal(one, two)


def test_a_vehicle_that_somebody_holds_in_the_open_does_not_take_itself_for_trapped() -> None:
    place, target = np.array((0.0, 0.0, -3.0)), np.array((60.0, 0.0, -3.0))
    crowd = np.array([disc(60.0 + k, 0.0, 0.5) for k in range(7)] + [disc(6.0, 3.0, 0.5)])
    far = np.array([disc(80.0, 5.0, 0.5)])
    strategy = planner()
    modes = [strategy.step(seen(PERIOD_S * k, place, np.zeros(3), target, crowd if k < 20 else far)).mode for k in range(80)]
    assert set(modes) == {"pursue"}


def test_without_its_own_state_it_holds_the_command_for_a_moment_and_then_stands() -> None:
    strategy = planner()
    place, target, none = np.zeros(3), np.array((20.0, 0.0, 0.0)), np.zeros((0, 7))
    first = strategy.step(seen(0.0, place, np.zeros(3), target, none))
    lost = [strategy.step(seen(0.1 * k, np.full(3, math.nan), np.zeros(3), target, none)) for k in range(1, 5)]
    assert np.linalg.norm(first.velocity_ned_m_s) > 0.0
    np.testing.assert_array_equal(lost[0].velocity_ned_m_s, first.velocity_ned_m_s)
    assert not lost[-1].velocity_ned_m_s.any()
    assert lost[-1].mode == "hold"


def test_a_repeated_observation_repeats_the_decision() -> None:
    strategy = planner()
    observation = seen(0.0, np.zeros(3), np.zeros(3), np.array((20.0, 0.0, 0.0)), np.zeros((0, 7)))
    assert strategy.step(observation) is strategy.step(replace(observation, dt_s=0.0))


def test_inside_an_obstacle_it_leaves_by_the_nearest_way() -> None:
    decision = planner().step(
        seen(0.0, np.array((0.5, 0.0, 0.0)), np.zeros(3), np.array((-9.0, 0.0, 0.0)), np.array([disc(0, 0, 1)]))
    )
    assert decision.mode == "leave"
    assert decision.velocity_ned_m_s[0] > 0.0


def test_a_goal_inside_an_obstacle_is_moved_out_and_told() -> None:
    decision = planner().step(seen(0.0, np.zeros(3), np.zeros(3), np.array((20.0, 0.0, 0.0)), np.array([disc(20.5, 0.0, 1.0)])))
    assert decision.diagnostics["goal_projected"]
    assert decision.goal_ned_m is not None
    assert math.dist(decision.goal_ned_m[:2], (20.5, 0.0)) == pytest.approx(1.5)


def test_what_a_name_fixes_and_what_does_not_exist_is_refused() -> None:
    with pytest.raises(InputError, match=r"conventional-apf.*modules"):
        planner("conventional-apf", modules="AB")
    with pytest.raises(InputError, match="modules"):
        planner(modules="BA")
