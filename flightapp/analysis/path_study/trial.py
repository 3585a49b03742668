"""One planner in one scene."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from flightapp.analysis.path_study.tracking import fly
from flightapp.core.clock import thread_cpu_ns
from flightapp.core.types import Array
from flightapp.planning.path_planning.api import Budget, Path, PathPlanner, Problem
from flightapp.planning.path_planning.flight import plan_flight
from flightapp.planning.path_planning.registry import make_path_planner
from flightapp.planning.path_planning.trajectory import FlightLimits
from flightapp.space.random_scene import Scene
from flightapp.space.world import World

BODY_M, SAFE_M, TRACKING_M = 0.25, 1.0, 1.0
CHECK_S = 0.005
"""Between the places at which the way's clearance is measured: 5 cm at top speed."""
GAP_M = BODY_M + SAFE_M + TRACKING_M
"""Radius of the vehicle, safety distance and room for the tracking error (specification, section 2.2)."""
LIMITS = FlightLimits(speed_max_m_s=10.0, climb_rate_max_m_s=10.0, acceleration_max_m_s2=6.0)
"""v_ref and a_max of the paper, which has no limit of its own for climbing."""


@dataclass(frozen=True, slots=True)
class Trial:
    """Lengths in m, times in s; what does not exist without a way is NaN.

    direct: the straight way was free, so that no planner was asked, and nothing more is measured. planning_s: CPU time of the
    planner, whole_s: of all from the question to the time law. path_m: as the planner gave it, length_m: of the flight.
    error_m: greatest, of the vehicle that tracks it. flyable: it does so within the room for that, with at least body and
    safety distance around it.
    """

    planner: str
    scene: str
    found: bool
    direct: bool
    planning_s: float
    whole_s: float
    path_m: float = np.nan
    length_m: float = np.nan
    detour: float = np.nan
    clearance_m: float = np.nan
    duration_s: float = np.nan
    error_m: float = np.nan
    flown_clearance_m: float = np.nan
    flyable: bool = False
    reason: str = ""


@dataclass(slots=True)
class _Timed:
    """Measures the planner; OMPL's planners get a deadline of `seconds` CPU time, the own ones their iterations."""

    planner: PathPlanner
    seconds: float | None
    spent_ns: int = 0
    asked: list[Path] = field(default_factory=list)

    def plan(self, problem: Problem, budget: Budget, seed: int) -> Path:
        begun = thread_cpu_ns()
        if self.seconds is not None:
            until = begun + round(self.seconds * 1e9)
            budget = replace(budget, iterations=10**9, may_go_on=lambda: thread_cpu_ns() < until)
        path = self.planner.plan(problem, budget, seed)
        self.spent_ns += thread_cpu_ns() - begun
        self.asked.append(path)
        return path


def problem_of(scene: Scene) -> Problem:
    world = World.of(scene.shapes)
    return Problem(world, scene.start_ned_m, scene.goal_ned_m, scene.low_ned_m, scene.high_ned_m, GAP_M, GAP_M)


def run_trial(name: str, scene: Scene, seed: int, iterations: int, peers_s: float) -> tuple[Trial, Array]:
    """The trial and the way that is flown, as places (n, 3); none without a flight."""
    problem = problem_of(scene)
    planner = _Timed(make_path_planner(name), peers_s if name.startswith("ompl-") else None)
    begun = thread_cpu_ns()
    flight = plan_flight(problem, planner, Budget(iterations), seed, LIMITS)
    whole_s = (thread_cpu_ns() - begun) * 1e-9
    direct = not planner.asked
    trial = Trial(name, scene.name, flight.trajectory is not None, direct, planner.spent_ns * 1e-9, whole_s, reason=flight.reason)
    if flight.trajectory is None:
        return trial, np.zeros((0, 3))
    if direct:
        return trial, np.stack((scene.start_ned_m, scene.goal_ned_m))
    way = np.array([flight.trajectory.at(t).position_ned_m for t in np.arange(0.0, flight.trajectory.duration_s, CHECK_S)])
    flown = fly(flight.trajectory, LIMITS.acceleration_max_m_s2)
    around = min(problem.world.signed_distance_m(place) for place in flown.positions_ned_m)
    straight = float(np.linalg.norm(scene.goal_ned_m - scene.start_ned_m))
    found = replace(
        trial,
        path_m=flight.path.length_m,
        length_m=flight.trajectory.length_m,
        detour=flight.trajectory.length_m / straight,
        clearance_m=min(problem.world.signed_distance_m(place) for place in way),
        duration_s=flight.trajectory.duration_s,
        error_m=flown.error_m,
        flown_clearance_m=around,
        flyable=bool(flown.error_m <= TRACKING_M and around >= BODY_M + SAFE_M),
    )
    return found, way
