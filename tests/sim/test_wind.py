"""The harmonic wind: the formula, the same air for everybody, and both simulators carried by it alike."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from flightapp.config.wind import HarmonicWind
from flightapp.core.errors import InputError
from flightapp.sim.batch import load_scenario
from flightapp.sim.batch.multirotor import fly_frame
from flightapp.sim.batch.records import frame_records, vehicle_records
from flightapp.sim.batch.setup import lay_out
from flightapp.sim.multirotor import Command, Multirotor, MultirotorLimits, Wind
from flightapp.sim.wind import HEADER, air, air_speed_max, air_velocity, drawn

SCENARIOS = Path(__file__).resolve().parents[2] / "missions" / "scenarios"
WIND = HarmonicWind()


def test_the_air_moves_as_the_formula_says() -> None:
    waves = drawn(WIND, 11)
    for axis, amplitudes in enumerate(
        (WIND.amplitudes_horizontal_m_s, WIND.amplitudes_horizontal_m_s, WIND.amplitudes_vertical_m_s)
    ):
        phases = waves[HEADER + 3 * 3 * axis : HEADER + 3 * 3 * (axis + 1)].reshape(3, 3)[:, 2]
        for t_s, height_m in ((0.0, 0.0), (4.9, 25.0), (5.0, 50.0), (17.3, 100.0)):
            waved = sum(a * math.sin(w * t_s + p) for a, w, p in zip(amplitudes, WIND.frequencies_rad_s, phases, strict=True))
            step = WIND.step_ned_m_s[axis] if t_s >= WIND.step_at_s else 0.0
            assert air_velocity(waves, axis, t_s, height_m) == pytest.approx((waved + step) * (1.0 + 0.5 * height_m / 50.0))


def test_the_seed_alone_makes_the_phases_and_no_moment_exceeds_the_bound() -> None:
    assert (drawn(WIND, 5) == drawn(WIND, 5)).all()
    assert (drawn(WIND, 5) != drawn(WIND, 6)).any()
    waves = drawn(WIND, 5)
    fastest = max(
        math.hypot(air_velocity(waves, 0, t, 30.0), air_velocity(waves, 1, t, 30.0)) for t in np.arange(0.0, 60.0, 0.05)
    )
    assert 0.5 * air_speed_max(waves, 30.0) < fastest <= air_speed_max(waves, 30.0)


def test_both_simulators_drift_alike_in_it() -> None:
    """The same frame, the same velocity loop, the same air: the plane of the fast simulator and the mock's multirotor."""
    scenario = load_scenario(
        SCENARIOS / "a2-dense.toml",
        {"pursuers.model": '"multirotor"', "evader.model": '"multirotor"', "wind.harmonic": "{ step_at_s = 1.0 }"},
    )
    assert scenario.wind.harmonic is not None
    blowing = air(scenario.wind.harmonic, 3)
    frames = frame_records(scenario)
    pursuers = scenario.pursuers
    limits = MultirotorLimits(
        speed_max_m_s=pursuers.speed_max_m_s,
        acceleration_max_m_s2=float(frames[0]["frame_acceleration"]),
        jerk_max_m_s3=float(frames[0]["frame_jerk"]),
        response_s=pursuers.response_s,
        velocity_gain_1_s=pursuers.velocity_gain_1_s,
        drag_1_s=pursuers.drag_1_s,
        disturbance_estimate_s=pursuers.disturbance_estimate_s,
    )
    mock = Multirotor(limits, position_ned_m=(0.0, 0.0, -5.0), wind=Wind(air=blowing), ground_down_m=0.0)
    mock.motors.running, mock.on_ground = True, False
    vehicles = vehicle_records(lay_out(scenario, 0))
    north, east = float(vehicles[0]["n"]), float(vehicles[0]["e"])
    step_s, drift = scenario.sub_step_s, 0.0
    for step in range(300):
        wind = blowing(step * step_s, 5.0)
        mock.step(step_s, Command((0.0, 0.0, 0.0)))
        fly_frame(vehicles, frames, 0, 0.0, 0.0, 0.0, wind[0], wind[1], step_s)
        drift = max(drift, math.hypot(vehicles[0]["n"] - north, vehicles[0]["e"] - east))
    assert drift > 0.1, "the wind was not felt"
    there = (vehicles[0]["n"] - north, vehicles[0]["e"] - east)
    assert mock.position_ned_m[:2] == pytest.approx(there, abs=0.2)


def test_a_wind_without_an_amplitude_for_each_frequency_is_refused_in_one_sentence() -> None:
    with pytest.raises(InputError, match="amplitudes_horizontal_m_s: 3 values; one for each of the 2"):
        load_scenario(
            SCENARIOS / "a2-dense.toml",
            {"pursuers.model": '"multirotor"', "wind.harmonic": "{ frequencies_rad_s = [0.4, 1.1] }"},
        )
