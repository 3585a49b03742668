"""How much faster than real time the fast simulator flies full planners, on one core."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from flightapp.core.clock import monotonic_ns, thread_cpu_ns
from flightapp.sim.batch.episode import fly
from flightapp.sim.batch.scenario import load_scenario

RATE_AIM = 500.0
FIRST_SEED = 10_000
"""Not among the seeds that results are reported on."""
PLANNER = "ac2f"


@dataclass(frozen=True, slots=True)
class Throughput:
    """Simulated time over wall time and over CPU time of the thread, set-up of the episodes included."""

    scenario: str
    planner: str
    pursuers: int
    episodes: int
    simulated_s: float
    simulated_s_per_s: float
    simulated_s_per_cpu_s: float
    aim: float

    @property
    def verdict(self) -> str:
        """How the rate compares with the aim: a busy machine takes wall time but hardly CPU time."""
        if self.simulated_s_per_s >= self.aim:
            return "met"
        return "met in CPU time" if self.simulated_s_per_cpu_s >= self.aim else "missed"


def simulator_throughput(scenario_path: Path, seconds: float) -> Throughput:
    """Episodes of `scenario_path`, one after the other, for about `seconds`; the first only warms up."""
    scenario = load_scenario(scenario_path)
    fly(scenario, PLANNER, FIRST_SEED)
    began_ns, began_cpu_ns = monotonic_ns(), thread_cpu_ns()
    episodes, simulated_s = 0, 0.0
    while episodes == 0 or monotonic_ns() < began_ns + round(seconds * 1e9):
        episodes += 1
        simulated_s += fly(scenario, PLANNER, FIRST_SEED + episodes).duration_s
    wall_s, cpu_s = (monotonic_ns() - began_ns) * 1e-9, (thread_cpu_ns() - began_cpu_ns) * 1e-9
    return Throughput(
        scenario.name,
        PLANNER,
        scenario.pursuers.count,
        episodes,
        simulated_s,
        simulated_s / wall_s,
        simulated_s / cpu_s,
        RATE_AIM,
    )
