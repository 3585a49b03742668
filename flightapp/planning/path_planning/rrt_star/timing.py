"""When an edge of the tree is flown: what the predictive check and the nodes' times rest on (section 2.3.3)."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.path_planning.rrt_star.question import QUESTION, Question
from flightapp.planning.path_planning.rrt_star.tree import ARRIVAL, NONE, PARENT, SPEED, TREE, D, E, N, Tree
from flightapp.space.bodies import BODIES, NUMBER, WHOLE
from flightapp.space.contact import first_contact

PAIR = numba.types.UniTuple(NUMBER, 2)  # type: ignore[no-untyped-call]
SPEED_MIN_M_S = 0.1


@compiled(PAIR(NUMBER, NUMBER, NUMBER, NUMBER))
def edge_timing(length_m: float, speed_m_s: float, speed_max_m_s: float, acceleration_m_s2: float) -> tuple[float, float]:
    """(duration in s, speed at the end) of an edge entered at `speed_m_s`: accelerate, then hold the highest speed.

    The paper's recursion drives the speed to the mean and reaches 75 to 96 % of the length; this covers all of it.
    """
    entry = min(speed_m_s, speed_max_m_s)
    end = min(speed_max_m_s, math.sqrt(entry * entry + 2.0 * acceleration_m_s2 * length_m))
    accelerating = (end - entry) / acceleration_m_s2
    rest = length_m - 0.5 * (entry + end) * accelerating
    return accelerating + max(0.0, rest) / end if end > 0.0 else 0.0, end


@compiled(NUMBER(TREE, QUESTION, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER))
def corner_speed(tree: Tree, q: Question, node: int, along_n: float, along_e: float, along_d: float, length_m: float) -> float:
    """With which speed `node` can be left by `along`: a corner of angle phi is rounded over half a step on each side."""
    parent = tree.links[node, PARENT]
    speed: float = tree.nodes[node, SPEED]
    if parent == NONE:
        return speed
    n = tree.nodes[node, N] - tree.nodes[parent, N]
    e = tree.nodes[node, E] - tree.nodes[parent, E]
    d = tree.nodes[node, D] - tree.nodes[parent, D]
    before = math.sqrt(n * n + e * e + d * d)
    if before == 0.0 or length_m == 0.0:
        return speed
    cos = max(-1.0, min(1.0, (n * along_n + e * along_e + d * along_d) / (before * length_m)))
    half = 0.5 * math.acos(cos)
    tangent = math.tan(half)
    if tangent <= 1e-6:
        return speed
    limit: float = math.sqrt(q.acceleration_m_s2 * 0.5 * min(before, length_m) / tangent)
    return max(SPEED_MIN_M_S, min(speed, limit))


@compiled(numba.types.boolean(BODIES, TREE, QUESTION, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def is_edge_met(
    moving: Array,
    tree: Tree,
    q: Question,
    node: int,
    along_n: float,
    along_e: float,
    along_d: float,
    length_m: float,
    lasts_s: float,
) -> bool:
    """Whether a moving body comes nearer than `q.moving_gap_m` while the edge from `node` by `along` is flown."""
    if lasts_s <= 0.0 or length_m <= 0.0:
        return False
    share = 1.0 / lasts_s
    n, e, d = tree.nodes[node, N], tree.nodes[node, E], tree.nodes[node, D]
    starts = tree.nodes[node, ARRIVAL]
    found = first_contact(moving, n, e, d, share * along_n, share * along_e, share * along_d, starts, q.moving_gap_m, lasts_s)
    return found[1] >= 0
