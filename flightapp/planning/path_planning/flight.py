"""From a question to a flight: start and goal put right, a path, shortened, rounded, timed, and checked against what moves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from flightapp.planning.path_planning.api import Budget, Path, PathPlanner, Problem
from flightapp.planning.path_planning.ends import put_right
from flightapp.planning.path_planning.smoothing import SAMPLE_M, rounded, sampled, shortened
from flightapp.planning.path_planning.trajectory import FlightLimits, Trajectory, timed
from flightapp.space.bodies import V_DOWN, V_NORTH

ROUNDING_M = 0.3
"""More than the gap that is asked for, where it can be had: room for the corners to be rounded."""
SLOWER = (1.0, 0.85, 0.7, 0.55, 0.4, 0.3)
"""Shares of the speed that are tried where the way would meet what moves."""
CHECK_S = 0.1


@dataclass(frozen=True, slots=True)
class Flight:
    """A way that can be flown, or why there is none.

    path: as the planner gave it. gap_m: what the way keeps. start_moved, goal_moved: it leads from, or to, the nearest free
    place instead. sigma_m: of the smoothing. speed_share: below 1 where it gives way to what moves.
    """

    path: Path
    trajectory: Trajectory | None
    gap_m: float
    reason: str = ""
    start_moved: bool = False
    goal_moved: bool = False
    sigma_m: float = 0.0
    speed_share: float = 1.0


def plan_flight(
    problem: Problem, planner: PathPlanner, budget: Budget, seed: int, limits: FlightLimits, gap_min_m: float | None = None
) -> Flight:
    """A flight for `problem`; without a way, once more with twice the iterations, then with `gap_min_m`, then the reason."""
    for name, place in (("start", problem.start_ned_m), ("goal", problem.goal_ned_m)):
        if not (np.isfinite(place).all() and (place >= problem.low_ned_m).all() and (place <= problem.high_ned_m).all()):
            raise ValueError(f"{name}_ned_m = {place.tolist()}: must lie within the box from low_ned_m to high_ned_m")
    attempts = [(problem.gap_m, budget), (problem.gap_m, replace(budget, iterations=2 * budget.iterations))]
    if gap_min_m is not None and gap_min_m < problem.gap_m:
        attempts.append((gap_min_m, budget))
    refused = Flight(_none(), None, problem.gap_m)
    for gap, allowed in attempts:
        flight = _attempt(replace(problem, gap_m=gap), planner, allowed, seed, limits)
        if flight.trajectory is not None:
            return flight
        refused = flight if refused.reason == "" else refused
    return refused


def _attempt(problem: Problem, planner: PathPlanner, budget: Budget, seed: int, limits: FlightLimits) -> Flight:
    world, gap = problem.world, problem.gap_m
    start = put_right(world, problem.start_ned_m, gap, problem.low_ned_m, problem.high_ned_m, is_flown=True)
    goal = put_right(world, problem.goal_ned_m, gap, problem.low_ned_m, problem.high_ned_m)
    if start is None or goal is None:
        return Flight(
            _none(), None, gap, f"{'start' if start is None else 'goal'}: no place within 5 m keeps {gap:g} m from every body"
        )
    moved = (start is not problem.start_ned_m, goal is not problem.goal_ned_m)
    free = replace(problem, start_ned_m=start, goal_ned_m=goal)
    path = _path(free, planner, budget, seed)
    if not path.found:
        return Flight(path, None, gap, f"{path.reason} that keeps {gap:g} m from every body", *moved)
    short = shortened(world, path.points_ned_m, gap)
    ways = (short, path.points_ned_m) if len(world.moving) > 0 else (short,)  # a shortcut may meet what the path gave way to
    smooth = [rounded(world, way, gap) for way in ways]
    speed = 0.0 if moved[0] else problem.speed_m_s
    for share in SLOWER:
        slower = FlightLimits(
            share * limits.speed_max_m_s, share * limits.climb_rate_max_m_s, share * share * limits.acceleration_max_m_s2
        )
        for places, sigma in smooth:
            whole = places
            if moved[0]:
                out = np.stack((problem.start_ned_m, places[0]))
                whole = np.vstack((sampled(out, SAMPLE_M)[:-1], places))
            trajectory = timed(whole, slower, speed)
            if moving_gap_m(problem, trajectory) >= problem.moving_gap_m:
                return Flight(path, trajectory, gap, "", *moved, sigma, share)
    return Flight(path, None, gap, "at no speed does the way keep its distance from what moves", *moved)


def _path(problem: Problem, planner: PathPlanner, budget: Budget, seed: int) -> Path:
    """The straight way where it is free, else the planner's: with room for rounding if there is such a one."""
    ends = np.stack((problem.start_ned_m, problem.goal_ned_m))
    if problem.world.is_way_free(ends[0], ends[1], problem.gap_m) and len(problem.world.moving) == 0:
        return Path(ends, 0)
    roomy = replace(problem, gap_m=problem.gap_m + ROUNDING_M)
    if min(problem.world.resting_distance_m(end) for end in ends) > roomy.gap_m + 0.02:
        path = planner.plan(roomy, budget, seed)
        if path.found:
            return path
    return planner.plan(problem, budget, seed)


def moving_gap_m(problem: Problem, trajectory: Trajectory) -> float:
    """Smallest predicted distance to what moves while `trajectory` is flown; inf where nothing does.

    Checked every CHECK_S, less what both can fly in half of that: never too great.
    """
    if len(problem.world.moving) == 0:
        return math.inf
    fastest = float(np.linalg.norm(problem.world.moving[:, V_NORTH : V_DOWN + 1], axis=1).max())
    nearest = math.inf
    for t_s in np.arange(0.0, trajectory.duration_s + CHECK_S, CHECK_S):
        moment = trajectory.at(float(t_s))
        own = float(np.linalg.norm(moment.velocity_ned_m_s))
        slack = 0.5 * CHECK_S * (fastest + own + CHECK_S * problem.acceleration_max_m_s2)
        nearest = min(nearest, problem.world.moving_distance_m(moment.position_ned_m, float(t_s)) - slack)
    return nearest


def _none() -> Path:
    return Path(np.zeros((0, 3)), 0, "not looked for")
