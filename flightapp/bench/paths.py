"""Distances in three dimensions with the force that follows from them, and RRT* in the scene of its paper."""

from __future__ import annotations

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.core.errors import InputError
from flightapp.planning.path_planning.api import Budget, Problem
from flightapp.planning.path_planning.registry import make_path_planner
from flightapp.planning.path_planning.rrt_star.planner import RrtStar
from flightapp.planning.path_planning.rrt_star.sampling import pushed
from flightapp.space.random_scene import random_scene
from flightapp.space.shapes import Shape
from flightapp.space.world import World

BODIES = 100
ITERATIONS = 5000
FORCE = f"space, distances to {BODIES} bodies and their force"
RRT_STAR = f"path, RRT*-APF, {ITERATIONS} iterations, 17 bodies"
FORCE_AIM_MS = 0.02
RRT_STAR_AIM_MS = 100.0
GAP_M = 2.25
SEED = 11
EVERYWHERE_M = 500.0
"""A reach of the broad phase at which every body counts everywhere: the worst case."""


def path_measurements(seconds: float) -> list[Measurement]:
    """Both; `seconds` for all."""
    scene = random_scene(SEED)
    planner = make_path_planner("rrt-star-apf")
    if not isinstance(planner, RrtStar):
        raise InputError("rrt-star-apf: not the planner that this measures")
    problem = Problem(
        World.of(scene.shapes), scene.start_ned_m, scene.goal_ned_m, scene.low_ned_m, scene.high_ned_m, GAP_M, GAP_M
    )
    asked = planner.search(problem, SEED, 1).asked
    crowd = _crowd()
    if len(crowd.resting) != BODIES:
        raise RuntimeError(f"{len(crowd.resting)} bodies instead of {BODIES}: this would measure something else")
    force = measure(Work(FORCE, _place, lambda at: pushed(crowd.resting, crowd.cells, asked, *at), FORCE_AIM_MS), 0.2 * seconds)

    def plan(seed: int) -> None:
        path = planner.plan(problem, Budget(ITERATIONS), seed)
        if path.iterations != ITERATIONS:
            raise RuntimeError(f"{path.iterations} iterations instead of {ITERATIONS}: this would measure something else")

    return [force, measure(Work(RRT_STAR, lambda k: k, plan, RRT_STAR_AIM_MS), 0.8 * seconds)]


def _crowd() -> World:
    shapes: list[Shape] = []
    for seed in range(SEED, SEED + 10):
        shapes.extend(random_scene(seed, obstacles=17).shapes)
    return World.of(shapes[:BODIES], reach_m=EVERYWHERE_M)


def _place(k: int) -> tuple[float, float, float]:
    return (7.0 * k) % 100.0, (13.0 * k) % 100.0, -((3.0 * k) % 60.0)
