"""The loop of RRT*: sample, steer, choose a parent, rewire, remember who can see the goal."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.path_planning.rrt_star.question import QUESTION, Question
from flightapp.planning.path_planning.rrt_star.sampling import informed_place, pushed
from flightapp.planning.path_planning.rrt_star.timing import corner_speed, edge_timing, is_edge_met
from flightapp.planning.path_planning.rrt_star.tree import (
    ARRIVAL,
    COST,
    COUNT,
    NONE,
    SPEED,
    TREE,
    D,
    E,
    N,
    Tree,
    adopt,
    hang,
    near_nodes,
    nearest_node,
    shorten,
    squared_m2,
)
from flightapp.space.bodies import BODIES, INDICES, NUMBER, WHOLE
from flightapp.space.broad_phase import CELLS, Cells
from flightapp.space.way import is_way_free

GAIN_MIN_M = 1e-9
"""What a new parent must save."""
SAME_PLACE_M = 1e-6
RANDOM_NUMBERS = 4
"""That one iteration uses."""
BEST = numba.types.Tuple((NUMBER, WHOLE))  # type: ignore[no-untyped-call]


@compiled(BEST(TREE, QUESTION, INDICES))
def best_way(tree: Tree, q: Question, seeing: NDArray[np.int64]) -> tuple[float, int]:
    """(length, last node) of the best way by the present costs of the seeing[1:1 + seeing[0]] nodes; (inf, NONE) without any."""
    best, last = math.inf, NONE
    for place in range(1, 1 + seeing[0]):
        node = seeing[place]
        n, e, d = tree.nodes[node, N] - q.goal_n, tree.nodes[node, E] - q.goal_e, tree.nodes[node, D] - q.goal_d
        length = tree.nodes[node, COST] + math.sqrt(n * n + e * e + d * d)
        if length < best:
            best, last = length, node
    return best, last


@compiled(NUMBER(TREE, QUESTION, NUMBER))
def connection_radius_m(tree: Tree, q: Question, best_m: float) -> float:
    """gamma (ln n / n)^(1/3), gamma from the volume in which the tree still grows, at most `q.radius_max_m`."""
    volume = (q.high_n - q.low_n) * (q.high_e - q.low_e) * (q.high_d - q.low_d)
    if q.informed == 1.0 and best_m < math.inf:
        n, e, d = q.goal_n - q.start_n, q.goal_e - q.start_e, q.goal_d - q.start_d
        across2 = max(0.0, best_m * best_m - (n * n + e * e + d * d))
        volume = min(volume, math.pi / 6.0 * best_m * across2)
    count = float(tree.sizes[COUNT])
    gamma = q.radius_factor * 2.0 * (4.0 / 3.0) ** (1.0 / 3.0) * (volume / (4.0 / 3.0 * math.pi)) ** (1.0 / 3.0)
    radius: float = min(q.radius_max_m, gamma * (math.log(count + 1.0) / count) ** (1.0 / 3.0))
    return radius


@compiled(numba.types.boolean(BODIES, CELLS, BODIES, TREE, QUESTION, WHOLE, NUMBER, NUMBER, NUMBER))
def is_edge_free(
    bodies: Array, cells: Cells, moving: Array, tree: Tree, q: Question, node: int, n: float, e: float, d: float
) -> bool:
    """Whether the way from `node` to a place is free, of bodies at rest and, when it is flown, of those that move."""
    along_n, along_e, along_d = n - tree.nodes[node, N], e - tree.nodes[node, E], d - tree.nodes[node, D]
    if not is_way_free(
        bodies, cells, tree.nodes[node, N], tree.nodes[node, E], tree.nodes[node, D], along_n, along_e, along_d, q.gap_m
    ):
        return False
    if moving.shape[0] == 0:
        return True
    length = math.sqrt(along_n * along_n + along_e * along_e + along_d * along_d)
    speed = corner_speed(tree, q, node, along_n, along_e, along_d, length)
    lasts, _ = edge_timing(length, speed, q.speed_max_m_s, q.acceleration_m_s2)
    return not is_edge_met(moving, tree, q, node, along_n, along_e, along_d, length, lasts)


@compiled(numba.types.void(TREE, QUESTION, WHOLE, WHOLE))
def _time_edge(tree: Tree, q: Question, parent: int, node: int) -> None:
    """Arrival and speed of a node at the end of its parent's edge."""
    n = tree.nodes[node, N] - tree.nodes[parent, N]
    e = tree.nodes[node, E] - tree.nodes[parent, E]
    d = tree.nodes[node, D] - tree.nodes[parent, D]
    length = math.sqrt(n * n + e * e + d * d)
    entry = corner_speed(tree, q, parent, n, e, d, length)
    lasts, tree.nodes[node, SPEED] = edge_timing(length, entry, q.speed_max_m_s, q.acceleration_m_s2)
    tree.nodes[node, ARRIVAL] = tree.nodes[parent, ARRIVAL] + lasts


@compiled(BEST(BODIES, CELLS, BODIES, TREE, QUESTION, INDICES, WHOLE, NUMBER, NUMBER, NUMBER, WHOLE, NUMBER))
def _cheapest_parent(
    bodies: Array,
    cells: Cells,
    moving: Array,
    tree: Tree,
    q: Question,
    near: NDArray[np.int64],
    found: int,
    n: float,
    e: float,
    d: float,
    parent: int,
    cost: float,
) -> tuple[float, int]:
    """(cost, node) of the best parent for a place: the cheapest of the `near` ones is tried first, so that few are checked."""
    tried = -math.inf
    while True:
        cheapest, candidate = cost - GAIN_MIN_M, NONE
        for place in range(found):
            node = near[place]
            if tree.nodes[node, COST] >= cheapest:
                continue
            through = tree.nodes[node, COST] + math.sqrt(squared_m2(tree, node, n, e, d))
            if tried < through < cheapest:
                cheapest, candidate = through, node
        if candidate == NONE:
            return cost, parent
        if is_edge_free(bodies, cells, moving, tree, q, candidate, n, e, d):
            return cheapest, candidate
        tried = cheapest


@compiled(numba.types.void(BODIES, CELLS, BODIES, TREE, QUESTION, INDICES, WHOLE, WHOLE, INDICES))
def _rewire(
    bodies: Array,
    cells: Cells,
    moving: Array,
    tree: Tree,
    q: Question,
    near: NDArray[np.int64],
    found: int,
    node: int,
    stack: NDArray[np.int64],
) -> None:
    """Lead to the `near` nodes through the new one wherever that is shorter."""
    n, e, d = tree.nodes[node, N], tree.nodes[node, E], tree.nodes[node, D]
    for place in range(found):
        other = near[place]
        if tree.nodes[node, COST] >= tree.nodes[other, COST]:
            continue
        through = tree.nodes[node, COST] + math.sqrt(squared_m2(tree, other, n, e, d))
        if through >= tree.nodes[other, COST] - GAIN_MIN_M:
            continue
        to_n, to_e, to_d = tree.nodes[other, N], tree.nodes[other, E], tree.nodes[other, D]
        if not is_edge_free(bodies, cells, moving, tree, q, node, to_n, to_e, to_d):
            continue
        adopt(tree, other, node)
        before = tree.nodes[other, ARRIVAL]
        if moving.shape[0] > 0:
            _time_edge(tree, q, node, other)
        earlier = before - tree.nodes[other, ARRIVAL]
        tree.nodes[other, ARRIVAL] = before
        shorten(tree, other, tree.nodes[other, COST] - through, earlier, stack)


@compiled(NUMBER(BODIES, CELLS, BODIES, TREE, QUESTION, BODIES, INDICES, INDICES, INDICES))
def grow(
    bodies: Array,
    cells: Cells,
    moving: Array,
    tree: Tree,
    q: Question,
    randoms: Array,
    seeing: NDArray[np.int64],
    near: NDArray[np.int64],
    stack: NDArray[np.int64],
) -> float:
    """One iteration for each row of randoms (m, RANDOM_NUMBERS) in [0, 1), while there is room; returns the best length, or inf.

    seeing: how many nodes can see the goal and which, grown here. near, stack: as long as the tree may grow.
    """
    best = best_way(tree, q, seeing)[0]
    direct = math.sqrt((q.goal_n - q.start_n) ** 2 + (q.goal_e - q.start_e) ** 2 + (q.goal_d - q.start_d) ** 2)
    for iteration in range(randoms.shape[0]):
        node = tree.sizes[COUNT]
        if node >= tree.nodes.shape[0]:
            break
        one, two, three = randoms[iteration, 1], randoms[iteration, 2], randoms[iteration, 3]
        if randoms[iteration, 0] < q.goal_share:
            n, e, d = q.goal_n, q.goal_e, q.goal_d
        elif q.informed == 1.0 and best < math.inf and direct > SAME_PLACE_M:
            n, e, d = informed_place(q, best, one, two, three)
            if not (q.low_n <= n <= q.high_n and q.low_e <= e <= q.high_e and q.low_d <= d <= q.high_d):
                continue
        else:
            n, e, d = (
                q.low_n + one * (q.high_n - q.low_n),
                q.low_e + two * (q.high_e - q.low_e),
                q.low_d + three * (q.high_d - q.low_d),
            )
        if q.push_share > 0.0 and (q.informed == 0.0 or best == math.inf):
            n, e, d = pushed(bodies, cells, q, n, e, d)
        parent = nearest_node(tree, n, e, d)
        along_n, along_e, along_d = n - tree.nodes[parent, N], e - tree.nodes[parent, E], d - tree.nodes[parent, D]
        distance = math.sqrt(along_n * along_n + along_e * along_e + along_d * along_d)
        if distance < SAME_PLACE_M:
            continue
        share = min(1.0, q.step_m / distance)
        n = tree.nodes[parent, N] + share * along_n
        e = tree.nodes[parent, E] + share * along_e
        d = tree.nodes[parent, D] + share * along_d
        to_goal = math.sqrt((n - q.goal_n) ** 2 + (e - q.goal_e) ** 2 + (d - q.goal_d) ** 2)
        from_start = math.sqrt((n - q.start_n) ** 2 + (e - q.start_e) ** 2 + (d - q.start_d) ** 2)
        if q.informed == 1.0 and from_start + to_goal >= best:
            continue
        if not is_edge_free(bodies, cells, moving, tree, q, parent, n, e, d):
            continue
        cost = tree.nodes[parent, COST] + share * distance
        found = near_nodes(tree, n, e, d, connection_radius_m(tree, q, best), near)
        cost, parent = _cheapest_parent(bodies, cells, moving, tree, q, near, found, n, e, d, parent, cost)
        tree.nodes[node, N], tree.nodes[node, E], tree.nodes[node, D], tree.nodes[node, COST] = n, e, d, cost
        adopt(tree, node, parent)
        hang(tree, node, n, e, d)
        tree.sizes[COUNT] = node + 1
        if moving.shape[0] > 0:
            _time_edge(tree, q, parent, node)
        _rewire(bodies, cells, moving, tree, q, near, found, node, stack)
        if to_goal < q.step_m and is_edge_free(bodies, cells, moving, tree, q, node, q.goal_n, q.goal_e, q.goal_d):
            seeing[0] += 1
            seeing[seeing[0]] = node
        best = best_way(tree, q, seeing)[0]
    return best
