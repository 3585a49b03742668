"""OMPL's planners as peers: AORRTC, RRT*, Informed RRT*, BIT* and RRTConnect, over compiled sphere tracing.

Needs the extra `ompl`. OMPL draws from random numbers of its own: the first seed of a process holds for all that follow. How
often a planner asks whether to stop counts as iterations, and differs between them: a deadline (`Budget.may_go_on`) is the
fairer budget. Bodies that move are not predicted: the flight's own check (`flight.plan_flight`) has to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flightapp.core.errors import InputError
from flightapp.core.types import Array
from flightapp.planning.parameters import StrategyParameters, parsed
from flightapp.planning.path_planning.api import Budget, Given, Path, PathPlanner, Problem

PLANNERS = {
    "ompl-aorrtc": "AORRTC",
    "ompl-bit-star": "BITstar",
    "ompl-informed-rrt-star": "InformedRRTstar",
    "ompl-rrt-connect": "RRTConnect",
    "ompl-rrt-star": "RRTstar",
}
WITH_RANGE = ("ompl-aorrtc", "ompl-informed-rrt-star", "ompl-rrt-connect", "ompl-rrt-star")
"""Those that have a longest edge."""


class OmplParameters(StrategyParameters):
    """What all of them share."""

    step_m: float = 10.0
    """Longest edge, where the planner has one."""


def build(name: str, given: Given) -> PathPlanner:
    """The planner `name` of PLANNERS; InputError where OMPL is not installed."""
    try:
        import ompl.geometric  # noqa: F401
    except ImportError:
        raise InputError(f"planner '{name}': OMPL is not installed; install it with: pip install 'flightapp[ompl]'") from None
    return OmplPlanner(name, parsed(OmplParameters, name, given).step_m)


@dataclass(frozen=True, slots=True)
class OmplPlanner:
    """One of OMPL's planners."""

    name: str
    step_m: float

    def plan(self, problem: Problem, budget: Budget, seed: int) -> Path:
        """The best path within the budget; a planner that does not improve its first path ends with it."""
        from ompl import base, geometric, util

        util.setLogLevel(util.LOG_NONE)
        util.RNG.setSeed(seed % (2**31 - 1) + 1)
        space = base.RealVectorStateSpace(3)
        bounds = base.RealVectorBounds(3)
        for axis in range(3):
            bounds.setLow(axis, float(problem.low_ned_m[axis]))
            bounds.setHigh(axis, float(problem.high_ned_m[axis]))
        space.setBounds(bounds)
        information = base.SpaceInformation(space)
        information.setStateValidityChecker(lambda state: problem.world.resting_distance_m(_place(state)) > problem.gap_m + 0.01)
        validator = _motion_validator(base, information, problem)
        information.setMotionValidator(validator)
        information.setup()
        definition = base.ProblemDefinition(information)
        definition.setStartAndGoalStates(_state(space, problem.start_ned_m), _state(space, problem.goal_ned_m))
        definition.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
        planner = getattr(geometric, PLANNERS[self.name])(information)
        if self.name in WITH_RANGE:
            planner.setRange(self.step_m)
        planner.setProblemDefinition(definition)
        planner.setup()
        asked = 0

        def is_over() -> bool:
            nonlocal asked
            asked += 1
            return asked > budget.iterations or not budget.may_go_on()

        planner.solve(base.PlannerTerminationCondition(is_over))
        if not definition.hasExactSolution():
            return Path(np.zeros((0, 3)), asked, f"no way from start to goal within {asked} iterations")
        path = definition.getSolutionPath()
        return Path(np.array([_place(state) for state in path.getStates()]), asked)


def _motion_validator(base: Any, information: Any, problem: Problem) -> Any:
    class Tracing(base.MotionValidator):  # type: ignore[misc]
        """Continuous, where OMPL's own would look at samples."""

        def checkMotion(self, one: Any, other: Any) -> bool:  # noqa: N802
            return problem.world.is_way_free(_place(one), _place(other), problem.gap_m)

    return Tracing(information)


def _state(space: Any, place: Array) -> Any:
    state = space.allocState()
    for axis in range(3):
        state[axis] = float(place[axis])
    return state


def _place(state: Any) -> Array:
    return np.array((state[0], state[1], state[2]))
