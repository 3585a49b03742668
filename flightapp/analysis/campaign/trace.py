"""One run flown again with everything kept: for its pictures and its recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flightapp.analysis.campaign.runner import own_parameters
from flightapp.core.types import Array, Decision, Observation, VehicleState
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.setup import lay_out


@dataclass(frozen=True, slots=True)
class Period:
    """One control period; pursuers first, the evader last."""

    t_s: float
    observations: tuple[Observation, ...]
    decisions: tuple[Decision, ...]
    states: tuple[VehicleState, ...]


@dataclass(frozen=True, slots=True)
class Trace:
    """A run with its world and all of its control periods."""

    scenario: Scenario
    layout: Layout
    result: RunResult
    periods: tuple[Period, ...]
    end: tuple[VehicleState, ...]
    """At the event that ended the run, or at the time limit."""

    @property
    def pursuers(self) -> int:
        return self.scenario.pursuers.count

    def times_s(self) -> Array:
        """(k + 1,): every control period, and the end."""
        return np.array([*(period.t_s for period in self.periods), self.result.duration_s])

    def positions_m(self) -> Array:
        """(k + 1, vehicles, 2) north, east at `times_s`."""
        return np.array([[state.position_ned_m[:2] for state in states] for states in self.states()])

    def states(self) -> list[tuple[VehicleState, ...]]:
        """True states at `times_s`, pursuers first and the evader last."""
        return [*(period.states for period in self.periods), self.end]

    def modes(self, pursuer: int) -> list[str]:
        """Mode of one pursuer in each control period."""
        return [period.decisions[pursuer].mode for period in self.periods]

    def distances_m(self) -> Array:
        """(k + 1,): from the evader to the nearest pursuer at `times_s`."""
        positions = self.positions_m()
        nearest: Array = np.linalg.norm(positions[:, :-1] - positions[:, -1:], axis=2).min(axis=1)
        return nearest


class _Keeper:
    def __init__(self) -> None:
        self.periods: list[Period] = []
        self.last: tuple[VehicleState, ...] = ()

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        self.periods.append(Period(t_s, tuple(observations), tuple(decisions), tuple(truth.states)))

    def end(self, truth: Truth) -> None:
        self.last = tuple(truth.states)


def trace(scenario: Scenario, planner: str, seed: int, parameters: Mapping[str, object] | None = None) -> Trace:
    """Fly one run again, which is exactly the one that a campaign flies, and keep everything."""
    keeper = _Keeper()
    result = fly(scenario, planner, seed, own_parameters(planner, parameters), keeper)
    return Trace(scenario, lay_out(scenario, seed), result, tuple(keeper.periods), keeper.last)
