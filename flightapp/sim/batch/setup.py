"""From a scenario and a seed to one concrete episode."""

from __future__ import annotations

import numpy as np

from flightapp.sim.batch.families.layout import Layout, Team
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.seeds import Stream, sequence
from flightapp.sim.batch.volume.heights import with_heights


def lay_out(scenario: Scenario, seed: int) -> Layout:
    """The layout of `seed`: the same for every planner, and for every scenario of the family with the same layout table."""
    random = np.random.default_rng(sequence(scenario.family, seed, Stream.LAYOUT))
    layout = scenario.layout.draw(Team(scenario.pursuers.count, scenario.inflation_m), random)
    return layout if scenario.volume is None else with_heights(layout, scenario.volume, scenario.family, seed)
