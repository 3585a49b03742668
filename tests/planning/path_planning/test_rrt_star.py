from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.planning.path_planning.api import Budget, Path, Problem
from flightapp.planning.path_planning.registry import PATH_PLANNERS, make_path_planner
from flightapp.planning.path_planning.rrt_star.planner import RrtStar
from flightapp.planning.path_planning.rrt_star.timing import edge_timing
from flightapp.planning.path_planning.rrt_star.tree import COST, COUNT, NONE, PARENT
from flightapp.space.random_scene import PAPER_WAYS
from flightapp.space.shapes import Sphere
from flightapp.space.world import World
from tests.planning.path_planning.scenes import WALL, room, scene_problem


def assert_keeps_its_distance(problem: Problem, path: Path) -> None:
    assert (path.points_ned_m[0] == problem.start_ned_m).all()
    assert (path.points_ned_m[-1] == problem.goal_ned_m).all()
    for start, end in zip(path.points_ned_m[:-1], path.points_ned_m[1:], strict=True):
        for share in np.linspace(0.0, 1.0, 2 + math.ceil(math.dist(start, end) / 0.2)):
            assert problem.world.signed_distance_m(start + share * (end - start)) >= problem.gap_m


def rrt_star(name: str = "rrt-star-apf", **parameters: object) -> RrtStar:
    planner = make_path_planner(name, parameters)
    assert isinstance(planner, RrtStar)
    return planner


@pytest.mark.parametrize("parameters", [{}, {"preset": "paper"}, {"push_share": 30.0, "informed": False}])
def test_the_way_leads_from_start_to_goal_and_keeps_its_distance(parameters: dict[str, object]) -> None:
    for seed, way in zip((3, 11, 29, 47), (*PAPER_WAYS, "level"), strict=True):
        problem = scene_problem(seed, way)
        path = rrt_star(**parameters).plan(problem, Budget(3000), seed)
        assert_keeps_its_distance(problem, path)


@pytest.mark.parametrize("step_m", [2.0, 10.0])
def test_the_best_way_never_grows_and_every_cost_is_the_way_to_the_root(step_m: float) -> None:
    problem = scene_problem(47)
    search = rrt_star(step_m=step_m, push_share=0.3).search(problem, 47, 3000)
    before = math.inf
    for _ in range(30):
        best = search.run(100)
        assert best <= before
        before = best
    assert before >= math.dist(problem.start_ned_m, problem.goal_ned_m)
    assert search.path().length_m == pytest.approx(before, abs=1e-9)
    count = int(search.tree.sizes[COUNT])
    assert count > 1000
    for node in range(0, count, 7):
        length, here, steps = 0.0, node, 0
        while (parent := int(search.tree.links[here, PARENT])) != NONE:
            length += math.dist(search.tree.nodes[here, :3], search.tree.nodes[parent, :3])
            here, steps = parent, steps + 1
            assert steps < count, "a ring in the tree"
        assert here == 0
        assert search.tree.nodes[node, COST] == pytest.approx(length, abs=1e-9)


def test_same_seed_same_tree_whatever_the_order_of_the_bodies() -> None:
    crowd = [Sphere(4.0 * k - 8.0, 3.1 * (k % 3) - 3.0, -5.0, 0.7 + 0.1 * k) for k in range(5)]  # several push each sample
    trees = []
    for bodies in (crowd, [crowd[k] for k in (3, 0, 4, 2, 1)]):
        problem = room(bodies, (-15.0, 0.0, -5.0), (15.0, 0.0, -5.0))
        search = rrt_star(informed=False).search(problem, 7, 1000)
        search.run(1000)
        trees.append(search.tree)
    assert trees[0].nodes.tobytes() == trees[1].nodes.tobytes()
    assert trees[0].links.tobytes() == trees[1].links.tobytes()
    other = rrt_star(informed=False).search(problem, 8, 1000)
    other.run(1000)
    assert other.tree.nodes.tobytes() != trees[0].nodes.tobytes()


def test_more_iterations_come_near_the_shortest_way_around_a_wall() -> None:
    problem = room([WALL], (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0))
    to_corner = math.hypot(9.5, 12.0)  # of the wall; then around it, 1 m away
    turned = math.pi - 2.0 * (math.atan2(9.5, 12.0) + math.asin(1.0 / to_corner))
    shortest = 2.0 * math.sqrt(to_corner**2 - 1.0) + 1.0 * turned + 1.0
    path = rrt_star().plan(problem, Budget(3000), 0)
    assert_keeps_its_distance(problem, path)
    assert shortest <= path.length_m < 1.06 * shortest


def test_without_a_way_it_says_so_and_how_near_it_came() -> None:
    closed = [WALL, type(WALL)(0.0, 16.0, 1.0, 10.0, -20.0, 1.0)]
    path = rrt_star().plan(room(closed, (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0)), Budget(1000), 0)
    assert not path.found
    assert path.reason == "no way from start to goal within 1000 iterations"
    assert math.dist(path.nearest_ned_m[-1], (10.0, 0.0, -5.0)) < 14.0
    assert path.length_m == math.inf


def test_a_caller_may_end_it_early() -> None:
    asked: list[bool] = []

    def may_go_on() -> bool:
        asked.append(True)
        return len(asked) < 3

    assert rrt_star().plan(scene_problem(11), Budget(100_000, may_go_on), 0).iterations == 1000


def test_edges_that_a_moving_body_will_meet_are_refused() -> None:
    crossing = Sphere(0.0, -24.0, -5.0, 3.0, (0.0, 6.0, 0.0))  # crosses the straight way when the vehicle would
    problem = room([crossing, Sphere(0.0, 0.0, -1.0, 0.1)], (-19.0, 0.0, -5.0), (19.0, 0.0, -5.0))
    heeding, not_heeding = (rrt_star(predictive=predictive).plan(problem, Budget(3000), 1) for predictive in (True, False))
    assert not_heeding.length_m == pytest.approx(38.0, abs=0.4)
    assert heeding.length_m > not_heeding.length_m + 0.2


@pytest.mark.parametrize("entry", [0.0, 2.0, 5.0, 10.0])
def test_the_timing_of_an_edge_covers_all_of_it(entry: float) -> None:
    for length in (0.5, 2.0, 10.0, 40.0):
        lasts, end = edge_timing(length, entry, 10.0, 3.0)
        accelerating = (end - entry) / 3.0
        assert 0.5 * (entry + end) * accelerating + end * (lasts - accelerating) == pytest.approx(length)
        assert entry <= end <= 10.0


@pytest.mark.parametrize("name", [name for name in PATH_PLANNERS if name.startswith("ompl")])
def test_peers_of_ompl_answer_the_same_question(name: str) -> None:
    pytest.importorskip("ompl")
    problem = room([WALL], (-10.0, 0.0, -5.0), (10.0, 0.0, -5.0))
    path = make_path_planner(name).plan(problem, Budget(4000 if name == "ompl-bit-star" else 400), 3)
    assert_keeps_its_distance(problem, path)


def test_unknown_planners_and_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="planner = 'dijkstra': no such path planner; known: ompl-aorrtc"):
        make_path_planner("dijkstra")
    with pytest.raises(InputError, match="'rrt-star-apf': step is not a parameter"):
        make_path_planner("rrt-star-apf", {"step": 2})


def test_a_goal_nearer_than_a_step_is_flown_to_straight() -> None:
    path = rrt_star().plan(room([WALL], (-10.0, 0.0, -5.0), (-8.0, 1.0, -5.0)), Budget(200), 0)
    assert path.points_ned_m.tolist() == [[-10.0, 0.0, -5.0], [-8.0, 1.0, -5.0]]


def test_samples_at_a_place_of_the_tree_are_skipped() -> None:
    here = np.array((1.0, 2.0, -5.0))
    problem = Problem(World.of([WALL]), here, here, here, here, 1.0, 1.0)
    search = rrt_star(informed=False).search(problem, 0, 100)
    search.run(100)
    assert int(search.tree.sizes[COUNT]) == 1
    assert np.isfinite(search.tree.nodes[0]).all()
