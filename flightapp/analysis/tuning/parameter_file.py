"""The file that tuning leaves behind: planner parameters as a mission or a campaign names them, and how they were found."""

from __future__ import annotations

import tomli_w

from flightapp.analysis.campaign.seeds import seeds_text
from flightapp.analysis.tuning.checkpoint import Evaluation
from flightapp.analysis.tuning.tune import Problem
from flightapp.analysis.tuning.weights import weights_of

DECIMALS = 4


def parameter_file(problem: Problem, best: Evaluation, evaluations: int, command: str) -> str:
    """TOML: the parameters besides the weights as they were, and the weights of `best`, which sum to 1."""
    found = weights_of(best.x1, best.x2)
    alpha, beta = round(found.alpha, DECIMALS), round(found.beta, DECIMALS)
    weights = {"weight_heading": alpha, "weight_clearance": beta, "weight_velocity": round(1.0 - alpha - beta, DECIMALS)}
    comment = (
        f"# Weights of the planner {problem.planner} for the scenario {problem.scenario.name}, made by",
        f"#     {command}",
        f"# J = {best.j:.2f} with {100 * best.success_rate:.1f} % captured on seeds {seeds_text(problem.seeds)}: "
        f"the best of {evaluations} evaluations.",
    )
    return "\n".join(comment) + "\n" + tomli_w.dumps({**problem.parameters, **weights})
