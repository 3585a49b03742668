"""A decision of `hunting` with 40 discs in reach, and one portion of a guidance search in the largest tree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import DISCS, far
from flightapp.core.types import Array, Limits, Observation
from flightapp.planning.guidance.tree import Tree
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.registry import make_planner

DECISION_AIM_MS = 2.0
PORTION_AIM_MS = 10.0
HALF_M = 40.0
"""Of the field that is searched."""


def hunting_measurements(limits: Limits, seconds: float) -> list[Measurement]:
    """Decisions, with all planning for the team but no search; the last portion of a search; `seconds` for both."""
    planner = make_planner("hunting", limits=limits, parameters={"guidance": False, "vehicle_radius_max_m": 0.0})
    parameters = HuntingParameters()

    def decide(seen: Observation) -> None:
        if planner.step(seen).mode == "hold":
            raise RuntimeError("the planner holds: this would measure something else")

    def portion(tree: Tree) -> None:
        tree.grow(STANDING, parameters.guidance_nodes_a_step)

    return [
        measure(Work(f"hunting, decision of one, {DISCS} discs", _moving, decide, DECISION_AIM_MS), seconds / 2),
        measure(
            Work(f"guidance, {parameters.guidance_nodes_a_step} tries of a search", _nearly_full, portion, PORTION_AIM_MS),
            seconds / 2,
        ),
    ]


def _moving(k: int) -> Observation:
    """`far`, with the target on a straight way."""
    seen = far(k)
    assert seen.target is not None
    return replace(seen, target=replace(seen.target, t_s=seen.t_s))


def _standing() -> Array:
    random = np.random.default_rng(3)
    return np.column_stack((random.uniform(-HALF_M, HALF_M, (DISCS, 2)), random.uniform(0.3, 1.5, DISCS)))


STANDING = _standing()


def _nearly_full(k: int) -> Tree:
    """A tree in which one portion is missing to the most nodes; it finds nothing."""
    parameters = HuntingParameters()
    tree = Tree((0.0, 0.0), (0.0, 0.0), (-HALF_M, -HALF_M, HALF_M, HALF_M), 2.0, parameters.guidance_nodes, k, stops=False)
    while tree.count < parameters.guidance_nodes - parameters.guidance_nodes_a_step and not tree.is_exhausted:
        tree.grow(STANDING, 100)
    return tree
