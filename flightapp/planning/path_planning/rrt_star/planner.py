"""RRT*-APF and RRT* as path planners."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.planning.parameters import parsed
from flightapp.planning.path_planning.api import Budget, Given, Path, PathPlanner, Problem
from flightapp.planning.path_planning.rrt_star.growth import RANDOM_NUMBERS, best_way, grow
from flightapp.planning.path_planning.rrt_star.parameters import PAPER, RrtStarParameters
from flightapp.planning.path_planning.rrt_star.question import Question, question
from flightapp.planning.path_planning.rrt_star.tree import COST, COUNT, NONE, PARENT, Tree, planted
from flightapp.space.shapes import no_bodies

BATCH = 500
"""Iterations between two questions whether to go on."""
RADIUS_MIN_M = 6.0
BASELINE: Mapping[str, object] = {"push_share": 0.0, "predictive": False}
"""What plain RRT* leaves out (section 3)."""


def build(name: str, given: Given) -> PathPlanner:
    """`rrt-star-apf`, the same with the paper's values, or the baseline `rrt-star`; InputError on parameters that are none."""
    values = dict(given or {})
    if name == "rrt-star-apf-paper":
        values.setdefault("preset", "paper")
    if values.get("preset") == "paper":
        values = PAPER | values
    if name == "rrt-star":
        values = {**values, **BASELINE}
    return RrtStar(parsed(RrtStarParameters, name, values))


@dataclass(slots=True)
class Search:
    """A tree that can go on growing: the anytime form of the planner."""

    problem: Problem
    tree: Tree
    asked: Question
    seeing: NDArray[np.int64]
    generator: np.random.Generator
    moving: Array
    iterations: int = 0
    best_m: float = math.inf

    def run(self, iterations: int) -> float:
        """Grow by that many iterations; returns the length of the best way in m, inf without one."""
        world, capacity = self.problem.world, len(self.tree.nodes)
        randoms = self.generator.random((iterations, RANDOM_NUMBERS))
        near, stack = np.empty(capacity, dtype=np.int64), np.empty(capacity, dtype=np.int64)
        self.best_m = grow(world.resting, world.cells, self.moving, self.tree, self.asked, randoms, self.seeing, near, stack)
        self.iterations += iterations
        return self.best_m

    def path(self) -> Path:
        """The best way so far."""
        _, last = best_way(self.tree, self.asked, self.seeing)
        if last == NONE:
            reason = f"no way from start to goal within {self.iterations} iterations"
            return Path(np.zeros((0, 3)), self.iterations, reason, self._to_root(self._nearest_to_goal()))
        return Path(np.vstack((self._to_root(last), self.problem.goal_ned_m)), self.iterations)

    def _to_root(self, node: int) -> Array:
        places = []
        while node != NONE:
            places.append(self.tree.nodes[node, :3].copy())
            node = int(self.tree.links[node, PARENT])
        return np.array(places[::-1])

    def _nearest_to_goal(self) -> int:
        places = self.tree.nodes[: self.tree.sizes[COUNT], :3]
        distances = np.linalg.norm(places - self.problem.goal_ned_m, axis=1)
        return int(np.lexsort((self.tree.nodes[: len(places), COST], distances))[0])


@dataclass(frozen=True, slots=True)
class RrtStar:
    """RRT* by `parameters`; stateless between calls."""

    parameters: RrtStarParameters

    def plan(self, problem: Problem, budget: Budget, seed: int) -> Path:
        """The straight way where it is free of bodies at rest and nothing moves, else the best one after the budget."""
        ends = np.stack((problem.start_ned_m, problem.goal_ned_m))
        if len(problem.world.moving) == 0 and problem.world.is_way_free(ends[0], ends[1], problem.gap_m):
            return Path(ends, 0)
        search = self.search(problem, seed, budget.iterations)
        while search.iterations < budget.iterations and budget.may_go_on():
            search.run(min(BATCH, budget.iterations - search.iterations))
        return search.path()

    def search(self, problem: Problem, seed: int, iterations_max: int) -> Search:
        """A tree of the start alone, which may grow for `iterations_max` iterations."""
        own = self.parameters
        capacity = iterations_max + 1
        tree = planted(problem.low_ned_m, problem.high_ned_m, problem.start_ned_m, problem.speed_m_s, capacity)
        return Search(
            problem=problem,
            tree=tree,
            asked=self._question(problem),
            seeing=np.zeros(capacity + 1, dtype=np.int64),
            generator=np.random.default_rng(seed),
            moving=problem.world.moving if own.predictive else no_bodies(),
        )

    def _question(self, problem: Problem) -> Question:
        own = self.parameters
        places = {"start": problem.start_ned_m, "goal": problem.goal_ned_m, "low": problem.low_ned_m, "high": problem.high_ned_m}
        radius = max(RADIUS_MIN_M, 1.5 * own.step_m) if own.radius_max_m is None else own.radius_max_m
        return question(
            **{f"{name}_{axis}": float(place[k]) for name, place in places.items() for k, axis in enumerate("ned")},
            gap_m=problem.gap_m,
            moving_gap_m=problem.moving_gap_m,
            step_m=own.step_m,
            radius_max_m=radius,
            radius_factor=own.radius_factor,
            goal_share=own.goal_share,
            informed=float(own.informed),
            push_share=own.push_share,
            push_gain=own.push_gain,
            push_reach_m=own.push_reach_m,
            speed_max_m_s=problem.speed_max_m_s,
            acceleration_m_s2=0.5 * problem.acceleration_max_m_s2,
        )
