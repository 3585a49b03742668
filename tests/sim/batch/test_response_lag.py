"""What the planners are told of a multirotor's lag is what the simulated one needs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flightapp.core.types import Decision
from flightapp.sim.batch.scenario import load_scenario
from flightapp.sim.batch.setup import lay_out
from flightapp.sim.batch.world import World

ENCIRCLE = Path(__file__).parents[3] / "missions" / "scenarios" / "a2-encircle.toml"
CRUISE_S, STEP_M_S = 5.0, 1.0


def flown(speed_m_s: float) -> Decision:
    return Decision(np.array((-speed_m_s, 0.0, 0.0)), None, 0.0, "test", None, "", {})


def test_the_lag_of_the_encircling_multirotors_is_that_of_their_step_response() -> None:
    scenario = load_scenario(ENCIRCLE, {"layout.discs": "0"})
    world = World(scenario, lay_out(scenario, 1), 1, 2)
    period_s = scenario.control_period_s
    steps = round(CRUISE_S / period_s)
    speeds = []
    for tick in range(2 * steps):
        speeds.append(-world.states(tick * period_s)[0].velocity_ned_m_s[0])
        world.advance(tick, [flown(4.0 + STEP_M_S * (tick >= steps)), flown(0.0), flown(0.0)])
    after = np.array(speeds[steps:])
    reached = after[0] + (1.0 - np.exp(-1.0)) * (4.0 + STEP_M_S - after[0])
    lag_s = period_s * np.argmax(after >= reached)
    assert scenario.planner.parameters["response_lag_s"] == pytest.approx(lag_s, abs=period_s)
    assert scenario.planner.parameters["reaction_s"] >= lag_s
