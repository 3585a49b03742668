"""The growing tree as flat arrays, and a grid hash over its nodes: nearest node, nodes within a radius, change of a parent."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.space.bodies import BODIES, INDICES, NUMBER, ROW, WHOLE

NONE = -1
CELL_M = 5.0
CELLS_MAX = 40
"""Along one axis: a larger box gets larger cells."""
SEARCHED_PLAINLY = 300
"""With fewer nodes than this, looking at each is faster than looking through mostly empty cells."""


N, E, D, COST, ARRIVAL, SPEED = range(6)
"""Columns of `Tree.nodes`: place; length of the way from the root in m; when in s and with which speed in m/s it is reached."""
PARENT, CHILD, SIBLING, NEXT = range(4)
"""Columns of `Tree.links`: parent, first child, next child of the same parent, next node in the same cell of the grid."""
COUNT, ROWS, COLUMNS, LAYERS = range(4)
"""Of `Tree.sizes`: nodes in use, the first is the root; cells along each axis."""
SIZE = 3
"""Of `Tree.grid`: north, east, down of its corner, size of a cell in m."""


class Tree(NamedTuple):
    """nodes and links are as long as the tree may grow; head is the first node of each cell, or NONE."""

    nodes: Array
    links: NDArray[np.int64]
    head: NDArray[np.int64]
    sizes: NDArray[np.int64]
    grid: Array


TREE = numba.types.NamedTuple((BODIES, numba.int64[:, ::1], INDICES, INDICES, ROW), Tree)  # type: ignore[no-untyped-call]


def planted(low: Array, high: Array, root: Array, speed_m_s: float, capacity: int) -> Tree:
    """A tree of its root alone within the box from `low` to `high` (3,)."""
    span = high - low
    size = max(CELL_M, float(span.max()) / CELLS_MAX)
    cells = (np.floor(span / size) + 1).astype(np.int64)
    tree = Tree(
        nodes=np.zeros((capacity, 6)),
        links=np.full((capacity, 4), NONE),
        head=np.full(int(cells.prod()), NONE),
        sizes=np.array((1, *cells)),
        grid=np.array((*low, size)),
    )
    tree.nodes[0] = (*root, 0.0, 0.0, speed_m_s)
    hang(tree, 0, *(float(value) for value in root))
    return tree


@compiled(WHOLE(TREE, WHOLE, NUMBER))
def _cell_along(tree: Tree, axis: int, value: float) -> int:
    """Which cell along an axis; what lies outside the box counts to the outermost."""
    cell: int = math.floor((value - tree.grid[axis]) / tree.grid[SIZE])
    return int(max(0, min(tree.sizes[ROWS + axis] - 1, cell)))


@compiled(numba.types.void(TREE, WHOLE, NUMBER, NUMBER, NUMBER))
def hang(tree: Tree, node: int, north: float, east: float, down: float) -> None:
    """Enter `node` into the grid."""
    row, column, layer = _cell_along(tree, 0, north), _cell_along(tree, 1, east), _cell_along(tree, 2, down)
    cell = (row * tree.sizes[COLUMNS] + column) * tree.sizes[LAYERS] + layer
    tree.links[node, NEXT] = tree.head[cell]
    tree.head[cell] = node


@compiled(NUMBER(TREE, WHOLE, NUMBER, NUMBER, NUMBER))
def squared_m2(tree: Tree, node: int, north: float, east: float, down: float) -> float:
    """Squared distance of a node to a point."""
    n, e, d = tree.nodes[node, N] - north, tree.nodes[node, E] - east, tree.nodes[node, D] - down
    squared: float = n * n + e * e + d * d
    return squared


@compiled(WHOLE(TREE, NUMBER, NUMBER, NUMBER, NUMBER, INDICES))
def near_nodes(tree: Tree, north: float, east: float, down: float, radius_m: float, near: NDArray[np.int64]) -> int:
    """Nodes within `radius_m` of a point into `near`; returns how many."""
    found = 0
    row_to, column_to = _cell_along(tree, 0, north + radius_m), _cell_along(tree, 1, east + radius_m)
    layer_from, layer_to = _cell_along(tree, 2, down - radius_m), _cell_along(tree, 2, down + radius_m)
    for row in range(_cell_along(tree, 0, north - radius_m), row_to + 1):
        for column in range(_cell_along(tree, 1, east - radius_m), column_to + 1):
            base = (row * tree.sizes[COLUMNS] + column) * tree.sizes[LAYERS]
            for layer in range(layer_from, layer_to + 1):
                node = tree.head[base + layer]
                while node != NONE:
                    if squared_m2(tree, node, north, east, down) <= radius_m * radius_m:
                        near[found] = node
                        found += 1
                    node = tree.links[node, NEXT]
    return found


@compiled(WHOLE(TREE, NUMBER, NUMBER, NUMBER))
def nearest_node(tree: Tree, north: float, east: float, down: float) -> int:
    """The nearest node; the older one of two that are equally near."""
    best, best2 = 0, math.inf
    count = tree.sizes[COUNT]
    if count < SEARCHED_PLAINLY:
        for node in range(count):
            distance2 = squared_m2(tree, node, north, east, down)
            if distance2 < best2:
                best, best2 = node, distance2
        return best
    row, column, layer = _cell_along(tree, 0, north), _cell_along(tree, 1, east), _cell_along(tree, 2, down)
    size = tree.grid[SIZE]
    ring = 0
    while best2 > (ring - 1) * (ring - 1) * size * size or ring == 0:
        for i in range(max(0, row - ring), min(tree.sizes[ROWS] - 1, row + ring) + 1):
            for j in range(max(0, column - ring), min(tree.sizes[COLUMNS] - 1, column + ring) + 1):
                edge = abs(i - row) == ring or abs(j - column) == ring
                k, k_to = max(0, layer - ring), min(tree.sizes[LAYERS] - 1, layer + ring)
                while k <= k_to:
                    if edge or abs(k - layer) == ring:
                        node = tree.head[(i * tree.sizes[COLUMNS] + j) * tree.sizes[LAYERS] + k]
                        while node != NONE:
                            distance2 = squared_m2(tree, node, north, east, down)
                            if distance2 < best2 or (distance2 == best2 and node < best):
                                best, best2 = node, distance2
                            node = tree.links[node, NEXT]
                    k += 1
        ring += 1
    return best


@compiled(numba.types.void(TREE, WHOLE, WHOLE))
def adopt(tree: Tree, node: int, parent: int) -> None:
    """Make `node` a child of `parent`, taking it from the parent that it has."""
    old = tree.links[node, PARENT]
    if old != NONE:
        if tree.links[old, CHILD] == node:
            tree.links[old, CHILD] = tree.links[node, SIBLING]
        else:
            before = tree.links[old, CHILD]
            while tree.links[before, SIBLING] != node:
                before = tree.links[before, SIBLING]
            tree.links[before, SIBLING] = tree.links[node, SIBLING]
    tree.links[node, PARENT] = parent
    tree.links[node, SIBLING] = tree.links[parent, CHILD]
    tree.links[parent, CHILD] = node


@compiled(numba.types.void(TREE, WHOLE, NUMBER, NUMBER, INDICES))
def shorten(tree: Tree, node: int, by_m: float, earlier_s: float, stack: NDArray[np.int64]) -> None:
    """The way to `node` has become shorter by `by_m` and quicker by `earlier_s`: so has that to all that descend from it."""
    stack[0] = node
    height = 1
    while height > 0:
        height -= 1
        here = stack[height]
        tree.nodes[here, COST] -= by_m
        tree.nodes[here, ARRIVAL] -= earlier_s
        child = tree.links[here, CHILD]
        while child != NONE:
            stack[height] = child
            height += 1
            child = tree.links[child, SIBLING]
