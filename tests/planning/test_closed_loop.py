"""Whole pursuits in the closed loop."""

from __future__ import annotations

import numpy as np
import pytest

from flightapp.planning.capture import CaptureRule
from flightapp.planning.registry import make_planner
from tests.planning.closed_loop import CAMERA, Flight, Scenario, demo, fly, limits, random_field


def assert_good(flight: Flight) -> None:
    assert flight.crossed_s is None
    assert flight.captured_s is not None
    assert flight.clearance_m > 0.0
    assert flight.separation_m > 1.0
    assert flight.evader_distance_m > 1.2


@pytest.mark.parametrize("seed", range(20))
def test_demo_with_ideal_sensing(seed: int) -> None:
    assert_good(fly(demo(seed), seed))


@pytest.mark.parametrize("seed", range(20))
def test_demo_through_a_camera(seed: int) -> None:
    assert_good(fly(demo(seed, sensing=CAMERA, target_noise_m=0.1, wind=(0.5, -0.5)), seed))


@pytest.mark.parametrize("seed", range(5))
def test_demo_as_the_application_flies_it(seed: int) -> None:
    flight = fly(demo(seed, supervised=True, sensing=CAMERA, target_noise_m=0.1), seed)
    assert_good(flight)
    assert flight.clearance_m >= 0.35
    assert flight.separation_m >= 1.8
    assert flight.guards[0]["separation"] + flight.guards[1]["separation"] < 60


@pytest.mark.parametrize("evader", ["straight", "hover"])
@pytest.mark.parametrize("seed", range(3))
def test_demo_against_other_evaders(evader: str, seed: int) -> None:
    assert_good(fly(demo(seed, sensing=CAMERA, evader_name=evader), seed))


@pytest.mark.parametrize("seed", range(10))
def test_random_fields(seed: int) -> None:
    scenario = random_field(seed)
    scenario.sensing = CAMERA
    assert_good(fly(scenario, seed))


@pytest.mark.parametrize("seed", range(3))
def test_the_source_capture_radius(seed: int) -> None:
    scenario: Scenario = demo(seed)
    scenario.rule = CaptureRule()
    flight = fly(scenario, seed)
    assert flight.crossed_s is None
    assert flight.captured_s is not None
    assert flight.clearance_m > 0.0


def test_three_pursuers_enclose_the_evader() -> None:
    scenario = demo(1)
    scenario.pursuers.append((0.0, 0.0, 0.0))
    assert_good(fly(scenario, 1))


def test_replay_is_bit_for_bit() -> None:
    scenario = demo(2, sensing=CAMERA)
    flight = fly(scenario, 2, keep=True)
    parameters = {"capture": scenario.rule.model_dump(), **scenario.parameters}
    for index in range(2):
        planner = make_planner("ac2f", limits=limits(), parameters=parameters)
        for _ in range(2):
            planner.reset()
            for (_, _, decisions), observations in zip(flight.log, flight.observations, strict=True):
                again = planner.step(observations[index])
                assert np.array_equal(again.velocity_ned_m_s, decisions[index].velocity_ned_m_s)
                assert (again.yaw_rad, again.mode, again.reason) == (
                    decisions[index].yaw_rad,
                    decisions[index].mode,
                    decisions[index].reason,
                )
