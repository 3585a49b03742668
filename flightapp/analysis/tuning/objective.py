"""What is minimised: J = T_cap + 0.2 L_path + 5 I_col + 100 I_fail - 0.5 d_min, averaged over a batch of runs."""

from __future__ import annotations

from collections.abc import Sequence

from flightapp.sim.batch.result import RunResult

PATH_WEIGHT, COLLISION_COST, FAILURE_COST, BOUNDARY_WEIGHT = 0.2, 5.0, 100.0, 0.5


def cost(run: RunResult) -> float:
    """J of one run. A collision, an escape or a time-out is a failure; its T_cap is the time at which the run ended."""
    time_s = run.duration_s if run.capture_time_s is None else run.capture_time_s
    value = time_s + PATH_WEIGHT * run.path_length_m - BOUNDARY_WEIGHT * run.boundary_distance_m
    value += COLLISION_COST * (run.outcome == "collided")
    return value + FAILURE_COST * (run.outcome != "captured")


def mean_cost(runs: Sequence[RunResult]) -> float:
    """J of a batch."""
    return sum(cost(run) for run in runs) / len(runs)
