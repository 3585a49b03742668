"""Each evader does what its name says, within its limits, and the same every time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Boundary, Limits
from flightapp.planning.api import Planner
from flightapp.planning.registry import evader_names, make_evader
from tests.planning.evasion.flight import LIMITS, chasing, disc, fly, observation

FLEEING = ("flee-nearest", "gap-runner", "goal-seeker", "inverse-square")
RUNNERS = ("adversarial", "boundary-seeking", "straight", "voronoi-centroid")
AVOIDING = ("adversarial", "boundary-seeking", "voronoi-centroid")
TREES = [disc(12.0, 0.0, 0.8), disc(9.0, 3.0, 1.2), disc(7.5, -2.5, 0.6)]


def evader(name: str, limits: Limits = LIMITS, seed: int = 0, **parameters: Any) -> Planner:
    return make_evader(name, limits=limits, parameters=parameters, seed=seed)


def test_names() -> None:
    others = {"climb-and-dive", "hover", "manoeuvring", "recorded", "random-waypoints", "waypoints"}
    assert set(evader_names()) == {*RUNNERS, *FLEEING, *others}


@pytest.mark.parametrize("name", RUNNERS)
def test_an_undefended_boundary_is_crossed_at_full_speed_then_it_stands(name: str) -> None:
    flight = fly(evader(name), (20.0, 3.0), 10.0)
    assert flight.crossed_s is not None
    assert flight.crossed_s < 20.0 / LIMITS.speed_max_m_s + 1.0
    assert flight.decisions[-1].mode == "crossed"
    assert np.array_equal(flight.decisions[-1].velocity_ned_m_s, np.zeros(3))


@pytest.mark.parametrize("name", AVOIDING)
def test_obstacles_on_the_way_are_flown_around(name: str) -> None:
    flight = fly(evader(name), (20.0, 0.3), 15.0, discs=TREES)
    assert flight.crossed_s is not None
    assert flight.clearance_m > 0.0


def test_straight_flies_through_obstacles_as_the_sources_evader_does() -> None:
    assert fly(evader("straight"), (20.0, 0.0), 10.0, discs=TREES).clearance_m < 0.0


def test_the_noise_of_straight_follows_its_seed() -> None:
    first, again, other = (fly(evader("straight", seed=seed), (20.0, 0.0), 5.0).path for seed in (1, 1, 2))
    assert first == again
    assert first != other
    sideways = [abs(east) for _, east in first]
    assert 0.0 < max(sideways) < 3.0


@pytest.mark.parametrize("name", AVOIDING)
def test_a_pursuer_in_the_way_is_not_touched(name: str) -> None:
    flight = fly(evader(name), (20.0, 0.2), 15.0, pursuers=[(8.0, 0.0)])
    assert flight.distance_m > 0.8


def test_voronoi_centroid_leaves_the_pursuers_behind() -> None:
    flight = fly(evader("voronoi-centroid", boundary_bias=0.0), (20.0, 0.0), 6.0, pursuers=[(20.0, 6.0), (26.0, 3.0)])
    start, end = flight.path[0], flight.path[-1]
    for pursuer in ((20.0, 6.0), (26.0, 3.0)):
        assert math.dist(end, pursuer) > math.dist(start, pursuer) + 3.0


def test_voronoi_centroid_without_bias_comes_to_rest_amid_its_pursuers() -> None:
    around = [(26.0, 0.0), (14.0, 0.0), (20.0, 6.0), (20.0, -6.0)]
    flight = fly(evader("voronoi-centroid", boundary_bias=0.0), (21.5, 1.0), 8.0, pursuers=around)
    assert math.dist(flight.path[-1], (20.0, 0.0)) < 0.05
    assert float(np.hypot(*flight.decisions[-1].velocity_ned_m_s[:2])) < 0.1


def test_voronoi_centroid_stays_in_the_flight_area_that_it_is_given() -> None:
    chased: dict[str, Any] = {"pursuers": [(0.0, 0.0)], "pursuit": chasing(1.5)}
    area = [0.0, -10.0, 40.0, 10.0]
    inside = fly(evader("voronoi-centroid", boundary_bias=0.0, area_m=area), (20.0, 0.0), 20.0, **chased)
    assert all(0.0 < north < 40.0 and -10.0 < east < 10.0 for north, east in inside.path)
    assert fly(evader("voronoi-centroid", boundary_bias=0.0), (20.0, 0.0), 20.0, **chased).path[-1][0] > 40.0


@pytest.mark.parametrize("guarded", [-1.0, 1.0])
def test_adversarial_takes_the_open_side(guarded: float) -> None:
    flight = fly(evader("adversarial"), (12.0, 0.0), 20.0, pursuers=[(4.0, guarded * 3.0)], pursuit=chasing(4.2))
    north, east = flight.path[15]
    assert north < 12.0
    assert guarded * east < -1.0


def test_adversarial_goes_to_the_nearest_point_where_it_is_first() -> None:
    decision = evader("adversarial").step(observation(0.0, (8.0, 4.0), pursuers=np.array([[60.0, 0.0, 0.0, 0.0]])))
    assert decision.goal_ned_m is not None
    assert tuple(decision.goal_ned_m[:2]) == pytest.approx((0.0, 4.0))


def test_adversarial_knows_that_a_contested_boundary_is_out_of_reach() -> None:
    """The Apollonius disc of a pursuer of twice the speed, head on, ends at a third of the way between the two."""
    pursuers = np.array([[5.0, 0.0, 0.0, 0.0]])
    decision = evader("adversarial", pursuer_speed_assumed_m_s=8.0).step(observation(0.0, (20.0, 0.0), pursuers=pursuers))
    assert decision.goal_ned_m is not None
    assert tuple(decision.goal_ned_m[:2]) == pytest.approx((15.0, 0.0))


def test_a_faster_evader_needs_nothing_but_limits() -> None:
    fast = Limits(9.0, 6.0, 60.0, 3.0, 12.0, 2.0, 0.25, 0.25)
    for name in RUNNERS:
        flight = fly(evader(name, fast), (30.0, 0.0), 10.0, pursuers=[(32.0, 2.0)], pursuit=chasing(6.0))
        assert flight.crossed_s is not None, name
        assert flight.crossed_s < 6.0, name


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(RUNNERS), st.integers(0, 10_000))
def test_commands_are_finite_within_limits_and_repeatable(name: str, seed: int) -> None:
    """Also among obstacles and pursuers that are on top of the evader, before any boundary."""
    random = np.random.default_rng(seed)
    boundary = Boundary(random.uniform(-20.0, 20.0, (int(random.integers(2, 6)), 2)), bool(random.integers(2)))
    first, second = evader(name, seed=seed), evader(name, seed=seed)
    own, velocity = random.uniform(-20.0, 20.0, 2), random.uniform(-4.0, 4.0, 2)
    pursuers = np.hstack((random.uniform(-20.0, 20.0, (3, 2)), random.uniform(-6.0, 6.0, (3, 2))))
    pursuers[0, :2] = own
    discs = [disc(*random.uniform(-20.0, 20.0, 2), random.uniform(0.1, 3.0)) for _ in range(random.integers(0, 80))]
    discs.append(disc(*own, 1.0))
    for tick in range(5):
        seen = observation(
            0.1 * tick, (own[0], own[1]), (velocity[0], velocity[1]), pursuers=pursuers, discs=discs, boundary=boundary
        )
        decision, same = first.step(seen), second.step(seen)
        assert np.array_equal(decision.velocity_ned_m_s, same.velocity_ned_m_s)
        assert decision.yaw_rad == same.yaw_rad
        assert np.isfinite(decision.velocity_ned_m_s).all()
        assert float(np.hypot(*decision.velocity_ned_m_s[:2])) <= LIMITS.speed_max_m_s + 1e-9
        assert decision.velocity_ned_m_s[2] == 0.0
        assert -math.pi < decision.yaw_rad <= math.pi
        velocity = decision.velocity_ned_m_s[:2]
        own = own + 0.1 * velocity


@pytest.mark.parametrize("name", RUNNERS)
def test_a_reset_evader_flies_the_same_again(name: str) -> None:
    policy = evader(name, seed=5)
    first = fly(policy, (10.0, 0.0), 6.0, pursuers=[(2.0, 4.0)], discs=TREES)
    policy.reset()
    assert fly(policy, (10.0, 0.0), 6.0, pursuers=[(2.0, 4.0)], discs=TREES).path == first.path
