"""The fast simulator: the application's planners in compiled worlds, without network and clock, the same bits for a seed."""

from flightapp.sim.batch.episode import Truth, Watcher, fly
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario, load_scenario
from flightapp.sim.batch.setup import lay_out

__all__ = ["RunResult", "Scenario", "Truth", "Watcher", "fly", "lay_out", "load_scenario"]
