"""Minimise J over the weights; every evaluation is a batch of runs on the same seeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.analysis.campaign.runner import fly_jobs, paired_jobs
from flightapp.analysis.campaign.workers import Workers
from flightapp.analysis.tuning.checkpoint import Checkpoint, Evaluation, begin, resume
from flightapp.analysis.tuning.objective import mean_cost
from flightapp.analysis.tuning.optimiser import first_points, suggest
from flightapp.analysis.tuning.weights import weights_of
from flightapp.core.errors import InputError
from flightapp.planning.registry import make_planner
from flightapp.sim.batch.facts import planner_parameters
from flightapp.sim.batch.scenario import Scenario

SEED_MIN = 10_000
"""Seeds below are those that results are reported on: parameters must not be chosen on them."""


@dataclass(frozen=True, slots=True)
class Problem:
    """What is optimised. `parameters`: of the planner, besides the weights."""

    scenario: Scenario
    planner: str
    seeds: tuple[int, ...]
    parameters: Mapping[str, object]
    initial: int
    seed: int

    def __post_init__(self) -> None:
        if self.seeds[0] < SEED_MIN:
            raise InputError(f"--seeds: {self.seeds[0]} is a seed that results are reported on; tune on seeds from {SEED_MIN}")
        _check_planner(self)

    def as_json(self) -> dict[str, Any]:
        """What must be the same for an optimisation to go on."""
        return {
            "scenario": self.scenario.model_dump(mode="json"),
            "planner": self.planner,
            "seeds": list(self.seeds),
            "parameters": dict(self.parameters),
            "initial": self.initial,
            "seed": self.seed,
        }


def _check_planner(problem: Problem) -> None:
    """InputError on an unknown planner or bad parameters, before anything flies."""
    parameters = planner_parameters(problem.scenario, problem.planner, problem.parameters)
    make_planner(problem.planner, limits=problem.scenario.pursuers.limits(), parameters=parameters)


def open_checkpoint(problem: Problem, path: Path, *, again: bool) -> Checkpoint:
    """A new checkpoint at `path`, or with `again` the one that is there."""
    return resume(path, problem.as_json()) if again else begin(path, problem.as_json())


def optimise(
    problem: Problem,
    checkpoint: Checkpoint,
    evaluations: int,
    workers: Workers,
    note: Callable[[Checkpoint], None] | None = None,
) -> bool:
    """Go on until there are initial + `evaluations` of them; False where a person ended it early.

    note: called after each evaluation.
    """
    first = first_points(problem.initial, problem.seed)
    while len(checkpoint.evaluations) < problem.initial + evaluations:
        done = len(checkpoint.evaluations)
        try:
            x1, x2 = first[done] if done < len(first) else suggest([e.sample() for e in checkpoint.evaluations], problem.seed)
        except KeyboardInterrupt:
            return False
        evaluation = _evaluate(problem, x1, x2, workers)
        if evaluation is None:
            return False
        checkpoint.add(evaluation)
        if note is not None:
            note(checkpoint)
    return True


def best_of(checkpoint: Checkpoint) -> Evaluation:
    """The evaluation of the least J, the first of several."""
    return min(checkpoint.evaluations, key=lambda one: one.j)


def _evaluate(problem: Problem, x1: float, x2: float, workers: Workers) -> Evaluation | None:
    """J at one point; None where a person ended it early."""
    parameters = {**problem.parameters, **weights_of(x1, x2).as_parameters()}
    flown = fly_jobs(problem.scenario, paired_jobs([problem.planner], problem.seeds), workers, parameters)
    if not flown.complete:
        return None
    j = mean_cost(flown.results)
    assert math.isfinite(j), f"J = {j} at x1 = {x1}, x2 = {x2}"
    captured = sum(run.outcome == "captured" for run in flown.results)
    return Evaluation(x1, x2, j, captured / len(flown.results))
