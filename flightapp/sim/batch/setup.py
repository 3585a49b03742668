"""From a scenario and a seed to one concrete episode."""

from __future__ import annotations

import numpy as np

from flightapp.sim.batch.families.layout import Layout, Team
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.seeds import Stream, sequence


def lay_out(scenario: Scenario, seed: int) -> Layout:
    """The layout of `seed`: the same for every planner, and for every scenario of the family with the same layout table."""
    random = np.random.default_rng(sequence(scenario.family, seed, Stream.LAYOUT))
    return scenario.layout.draw(Team(scenario.pursuers.count, scenario.inflation_m), random)
