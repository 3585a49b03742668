from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.path_planning.api import Budget, Path, Problem
from flightapp.planning.path_planning.flight import moving_gap_m, plan_flight
from flightapp.planning.path_planning.registry import make_path_planner
from flightapp.planning.path_planning.smoothing import rounded, shortened
from flightapp.planning.path_planning.trajectory import FlightLimits, Trajectory, timed
from flightapp.space.shapes import Cylinder, OrientedBox, Shape, Sphere
from flightapp.space.world import World
from tests.planning.path_planning.scenes import GAP_M, LIMITS, WALL, room, scene_problem

PLANNER = make_path_planner("rrt-star-apf")
corner = st.tuples(st.integers(-40, 40), st.integers(-40, 40), st.integers(-20, 0)).map(
    lambda given: np.array(given, dtype=float)
)


def sampled(trajectory: Trajectory, step_s: float = 0.01) -> list[tuple[Array, Array, Array]]:
    moments = [trajectory.at(float(t)) for t in np.arange(0.0, trajectory.duration_s, step_s)]
    return [(one.position_ned_m, one.velocity_ned_m_s, one.acceleration_ned_m_s2) for one in moments]


@settings(max_examples=15, deadline=None)
@given(st.lists(corner, min_size=2, max_size=5))
def test_a_rounded_way_is_flown_within_the_limits_and_without_a_jump(corners: list[Array]) -> None:
    places, _ = rounded(World.of([]), np.array(corners), GAP_M)
    trajectory = timed(places, LIMITS)
    assert (trajectory.at(0.0).position_ned_m == corners[0]).all()
    assert (trajectory.at(trajectory.duration_s + 1.0).position_ned_m == corners[-1]).all()
    before: tuple[Array, Array] | None = None
    for position, velocity, acceleration in sampled(trajectory, 0.02):
        speed = float(np.linalg.norm(velocity))
        assert speed <= 1.02 * LIMITS.speed_max_m_s
        assert abs(velocity[2]) <= 1.05 * LIMITS.climb_rate_max_m_s
        assert float(np.linalg.norm(acceleration)) <= 1.02 * LIMITS.acceleration_max_m_s2
        if before is not None:
            assert math.dist(position, before[0]) <= 0.02 * speed + 0.02
            assert math.dist(velocity, before[1]) <= 0.02 * 1.05 * LIMITS.acceleration_max_m_s2 + 1e-6
        before = (position, velocity)


def test_it_starts_with_the_speed_that_is_flown_and_ends_at_rest() -> None:
    trajectory = timed(np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [40.0, 0.0, 0.0]]), LIMITS, 4.0)
    assert trajectory.at(0.0).velocity_ned_m_s == pytest.approx([4.0, 0.0, 0.0])
    assert trajectory.at(trajectory.duration_s - 1e-9).velocity_ned_m_s == pytest.approx(np.zeros(3), abs=1e-6)
    assert trajectory.length_m == 40.0
    assert trajectory.slowed(0.5).duration_s == 2.0 * trajectory.duration_s
    assert timed(np.zeros((1, 3)), LIMITS).duration_s == 0.0


@pytest.mark.parametrize(("seed", "way"), [(11, "level"), (47, "descent"), (29, "climb")])
def test_the_papers_scenes_become_flights_that_keep_their_distance(seed: int, way: str) -> None:
    problem = scene_problem(seed, way)
    flight = plan_flight(problem, PLANNER, Budget(3000), seed, LIMITS)
    assert flight.trajectory is not None
    assert min(problem.world.signed_distance_m(position) for position, _, _ in sampled(flight.trajectory, 0.02)) >= GAP_M - 0.01
    assert flight.trajectory.length_m <= flight.path.length_m + 1e-6
    direct = math.dist(problem.start_ned_m, problem.goal_ned_m)
    assert direct - 1e-9 <= flight.trajectory.length_m < 1.05 * direct


def test_a_start_or_a_goal_in_collision_is_put_right_and_said() -> None:
    posts = [Cylinder(-10.0, 0.0, 2.0, -20.0, 1.0), Sphere(10.0, 0.0, -5.0, 1.0), WALL]
    problem = room(posts, (-10.5, 0.0, -5.0), (10.0, 0.3, -5.0))
    flight = plan_flight(problem, PLANNER, Budget(2000), 0, LIMITS)
    assert flight.start_moved
    assert flight.goal_moved
    assert flight.trajectory is not None
    assert (flight.trajectory.at(0.0).position_ned_m == problem.start_ned_m).all()
    end = flight.trajectory.at(math.inf).position_ned_m
    assert math.dist(end, problem.goal_ned_m) < 2.5
    assert problem.world.signed_distance_m(end) >= problem.gap_m


@pytest.mark.parametrize(
    ("bodies", "said"),
    [
        ([Sphere(10.0, 0.0, -5.0, 9.0)], "goal: no place within 5 m keeps 1 m from every body"),
        (
            [WALL, OrientedBox(0.0, 16.0, 1.0, 10.0, -20.0, 1.0)],
            "no way from start to goal within 500 iterations that keeps 1 m from every body",
        ),
        (
            [WALL, OrientedBox(0.0, 20.0, 1.0, 13.0, -20.0, 1.0)],
            "no way from start to goal within 500 iterations that keeps 1 m from every body",
        ),
    ],
)
def test_without_a_flight_it_says_why(bodies: list[Shape], said: str) -> None:
    flight = plan_flight(room(bodies, (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0)), PLANNER, Budget(500), 0, LIMITS)
    assert flight.trajectory is None
    assert flight.reason == said


def test_a_gap_in_a_wall_that_is_too_narrow_is_flown_with_the_smaller_gap_if_allowed() -> None:
    narrow = [WALL, OrientedBox(0.0, 20.0, 1.0, 13.0, -20.0, 1.0)]  # 1.5 m are left between them
    problem = room(narrow, (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0))
    flight = plan_flight(problem, PLANNER, Budget(4000), 0, LIMITS, gap_min_m=0.4)
    assert flight.trajectory is not None
    assert flight.gap_m == 0.4


def test_where_nothing_is_to_be_flown() -> None:
    flight = plan_flight(room([], (1.0, 1.0, -5.0), (1.0, 1.0, -5.0)), PLANNER, Budget(10), 0, LIMITS)
    assert flight.trajectory is not None
    assert flight.trajectory.duration_s == 0.0
    with pytest.raises(ValueError, match=r"goal_ned_m = .*must lie within the box"):
        plan_flight(room([], (1.0, 1.0, -5.0), (1.0, 100.0, -5.0)), PLANNER, Budget(10), 0, LIMITS)


def test_a_flight_gives_way_to_what_crosses() -> None:
    crossing = Sphere(0.0, -24.0, -5.0, 3.0, (0.0, 6.0, 0.0))
    problem = room([crossing], (-19.0, 0.0, -5.0), (19.0, 0.0, -5.0))
    straight = timed(np.array([[-19.0, 0.0, -5.0], [19.0, 0.0, -5.0]]), LIMITS)
    assert moving_gap_m(problem, straight) < 0.0
    for planner in (PLANNER, make_path_planner("rrt-star")):
        flight = plan_flight(problem, planner, Budget(1500), 0, LIMITS)
        assert flight.trajectory is not None
        for t_s in np.arange(0.0, flight.trajectory.duration_s, 0.02):
            there = flight.trajectory.at(float(t_s)).position_ned_m
            assert problem.world.signed_distance_m(there, float(t_s)) >= problem.moving_gap_m


def test_shortcuts_and_rounding_never_come_nearer_than_asked() -> None:
    world = World.of([Cylinder(0.0, 0.0, 3.0), Cylinder(8.0, 6.0, 2.0)])
    zigzag = np.array([[-10.0, 0.0, 0.0], [-6.0, 5.0, 0.0], [0.0, 5.5, 0.0], [3.0, 4.5, 0.0], [8.0, 2.0, 0.0], [14.0, 2.0, 0.0]])
    short = shortened(world, zigzag, 1.0)
    smooth, sigma = rounded(world, short, 1.0)
    assert len(short) < len(zigzag) + 2
    assert min(world.signed_distance_m(place) for place in smooth) >= 1.0
    assert (smooth[0] == zigzag[0]).all()
    assert (smooth[-1] == zigzag[-1]).all()
    assert sigma >= 0.0
    limited = timed(smooth, FlightLimits(3.0, 1.0, 2.0))
    assert max(float(np.linalg.norm(velocity)) for _, velocity, _ in sampled(limited)) <= 3.05


@pytest.mark.parametrize("seed", range(3))
def test_in_random_scenes_every_place_of_the_flight_keeps_its_distance(seed: int) -> None:
    """A few of the 200 scenes that `flightapp campaign paths --seeds 0-199 --planner rrt-star-apf` measures."""
    problem = scene_problem(20_000 + seed, ("level", "descent", "climb")[seed % 3])
    flight = plan_flight(problem, PLANNER, Budget(2000), seed, LIMITS)
    assert flight.trajectory is not None
    places = np.array([position for position, _, _ in sampled(flight.trajectory, 0.005)])
    assert (places[0] == problem.start_ned_m).all()
    assert math.dist(flight.trajectory.at(math.inf).position_ned_m, problem.goal_ned_m) == 0.0
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() <= 0.051
    assert min(problem.world.signed_distance_m(place) for place in places) >= GAP_M - 1e-3


def test_the_way_out_of_too_narrow_a_place_leads_through_no_wall() -> None:
    corridor = [OrientedBox(0.0, side, 12.0, 0.1, -20.0, 1.0) for side in (-0.5, 0.5)]
    problem = room([*corridor, WALL], (-4.0, 0.0, -5.0), (-15.0, 0.0, -5.0))
    flight = plan_flight(problem, PLANNER, Budget(2000), 0, LIMITS)
    assert flight.start_moved
    assert flight.trajectory is not None
    out = [position for position, _, _ in sampled(flight.trajectory, 0.02)]
    assert min(problem.world.signed_distance_m(place) for place in out) > 0.2


def test_a_start_from_which_nothing_leads_out_is_said() -> None:
    flight = plan_flight(
        room([Sphere(-10.0, 0.0, -5.0, 9.0)], (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0)), PLANNER, Budget(9), 0, LIMITS
    )
    assert flight.trajectory is None
    assert flight.reason == "start: no place within 5 m keeps 1 m from every body"


class FindsNothing:
    """Notes what it is asked."""

    def __init__(self) -> None:
        self.asked: list[tuple[float, int]] = []

    def plan(self, problem: Problem, budget: Budget, seed: int) -> Path:
        self.asked.append((problem.gap_m, budget.iterations))
        return Path(np.zeros((0, 3)), budget.iterations, "nothing")


def test_without_a_way_it_is_tried_again_for_twice_as_long_and_then_nearer_to_the_bodies() -> None:
    planner = FindsNothing()
    problem = room([WALL], (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0))
    flight = plan_flight(problem, planner, Budget(100), 0, LIMITS, gap_min_m=0.5)
    assert flight.trajectory is None
    assert planner.asked == [(1.3, 100), (1.0, 100), (1.3, 200), (1.0, 200), (0.8, 100), (0.5, 100)]
