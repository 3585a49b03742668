"""One tuning from its problem to its files: parameter file, checkpoint beside it, picture of the response surface."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.analysis.campaign.output_folder import ROOT
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.workers import Workers
from flightapp.analysis.summary import write_whole
from flightapp.analysis.tuning.checkpoint import Checkpoint
from flightapp.analysis.tuning.parameter_file import parameter_file
from flightapp.analysis.tuning.surface_picture import surface_picture
from flightapp.analysis.tuning.tune import Problem, best_of, open_checkpoint, optimise
from flightapp.analysis.tuning.weights import weights_of
from flightapp.core.errors import InputError


@dataclass(frozen=True, slots=True)
class Tuned:
    """What came of it; `summary` is what machines get, `complete` False where a person ended it early."""

    summary: dict[str, Any]
    complete: bool

    def text(self) -> str:
        """For a person to read."""
        one = self.summary
        if not one["evaluations"]:
            return "no evaluation was finished"
        weights = f"alpha {one['alpha']:.4f}, beta {one['beta']:.4f}, gamma {one['gamma']:.4f}"
        found = f"J {one['j']:.2f} at {weights}, {100 * one['success_rate']:.1f} % captured; {one['evaluations']} evaluations"
        if not self.complete:
            return f"{found}\ngo on with --resume"
        return f"{found}\nparameters: {one['output']}\npicture:    {one['picture']}"


def run_tuning(problem: Problem, evaluations: int, workers: Workers, output: Path | None, command: str, *, again: bool) -> Tuned:
    """Optimise and write; stopped early, only the checkpoint is left, from which `again` goes on."""
    target = output or ROOT / f"tune-{problem.scenario.name}.toml"
    if target.suffix != ".toml":
        raise InputError(f"--output {target}: must be the name of a .toml file")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--output {target}: its folder cannot be used: {error.strerror}; name another") from None
    checkpoint = open_checkpoint(problem, target.with_suffix(".jsonl"), again=again)
    complete = _optimised(problem, checkpoint, evaluations, workers)
    picture = target.with_suffix(".png")
    if complete:
        count = len(checkpoint.evaluations)
        title = f"{problem.scenario.name}, {problem.planner}: {count} evaluations of {len(problem.seeds)} runs"
        write_whole(picture, surface_picture(title, checkpoint.evaluations, problem.initial, problem.seed))
        write_whole(target, parameter_file(problem, best_of(checkpoint), count, command).encode())
    return Tuned(_summary(problem, checkpoint, target, picture), complete)


def _optimised(problem: Problem, checkpoint: Checkpoint, evaluations: int, workers: Workers) -> bool:
    total = problem.initial + evaluations
    with ProgressBar(f"tune {problem.scenario.name}", total, len(checkpoint.evaluations)) as bar:
        return optimise(problem, checkpoint, evaluations, workers, lambda now: bar.advance(1, f"least J {best_of(now).j:.2f}"))


def _summary(problem: Problem, checkpoint: Checkpoint, target: Path, picture: Path) -> dict[str, Any]:
    told = {"scenario": problem.scenario.name, "planner": problem.planner, "evaluations": len(checkpoint.evaluations)}
    if not checkpoint.evaluations:
        return told
    best = best_of(checkpoint)
    weights = weights_of(best.x1, best.x2)
    return {
        **told,
        "j": best.j,
        "success_rate": best.success_rate,
        "alpha": weights.alpha,
        "beta": weights.beta,
        "gamma": weights.gamma,
        "output": str(target),
        "picture": str(picture),
    }
