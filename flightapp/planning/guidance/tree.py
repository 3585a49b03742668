"""A rapidly exploring random tree between standing discs, grown by so many tries at a time and resumed later.

It ends at the first node from which the goal is in sight (SAGRRT; CPPPEA 2.7, Li et al. 2025). Unknown space counts as free.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numba import void
from numpy.typing import NDArray

from flightapp.core.clearance import way_gap_m
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

NODE_COLUMNS = 4
"""north_m, east_m, parent (its row; the root's is -1), way from the root in m."""
GOAL_SHARE = 0.1
"""Of the samples are the goal itself."""

ROWS = numba.float64[:, ::1]
NUMBER = numba.float64
PROGRESS = np.dtype(
    [
        ("count", "i8"),  # nodes
        ("tries", "i8"),
        ("found", "i8"),  # the node that sees the goal; -1: none yet
        ("nearest", "i8"),  # the node nearest to the goal
        ("random", "u8"),  # state of the generator
        ("goal_n", "f8"),
        ("goal_e", "f8"),
        ("low_n", "f8"),  # samples are drawn from this box
        ("low_e", "f8"),
        ("high_n", "f8"),
        ("high_e", "f8"),
        ("step_m", "f8"),  # longest edge
        ("stops", "i8"),  # 1: ends at the first node that sees the goal
    ],
    align=True,
)
PROGRESS_TYPE = numba.types.Array(numba.from_dtype(PROGRESS), 1, "C")


@compiled(numba.boolean(ROWS, NUMBER, NUMBER, NUMBER, NUMBER))
def is_barred(discs: Array, n: float, e: float, to_n: float, to_e: float) -> bool:
    """Whether the straight way meets one of `discs` (m, >=3: north, east, radius)."""
    along_n, along_e = to_n - n, to_e - e
    barred = False
    for i in range(discs.shape[0]):
        barred |= way_gap_m(n - discs[i, 0], e - discs[i, 1], along_n, along_e, discs[i, 2]) < 0.0
    return barred


@compiled(NUMBER(PROGRESS_TYPE))
def _uniform(progress: NDArray[np.void]) -> float:
    """The next number in [0, 1): xorshift64*."""
    p = progress[0]
    x = p.random
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    p.random = x
    scrambled = x * np.uint64(2685821657736338717)
    share: float = np.float64(scrambled >> np.uint64(11)) / 9007199254740992.0
    return share


@compiled(void(ROWS, PROGRESS_TYPE, ROWS, numba.int64))
def grow(discs: Array, progress: NDArray[np.void], nodes: Array, tries: int) -> None:
    """`tries` more samples, fewer once the goal is seen or `nodes` (k, NODE_COLUMNS), whose first row is the root, is full."""
    p = progress[0]
    if p.found < 0 and p.stops == 1 and p.count == 1 and not is_barred(discs, nodes[0, 0], nodes[0, 1], p.goal_n, p.goal_e):
        p.found = 0
    for _ in range(tries):
        if (p.found >= 0 and p.stops == 1) or p.count >= nodes.shape[0]:
            return
        p.tries += 1
        to_n, to_e = p.goal_n, p.goal_e
        if _uniform(progress) >= GOAL_SHARE:
            to_n = p.low_n + (p.high_n - p.low_n) * _uniform(progress)
            to_e = p.low_e + (p.high_e - p.low_e) * _uniform(progress)
        nearest, nearest2 = 0, math.inf
        for k in range(p.count):
            dn, de = nodes[k, 0] - to_n, nodes[k, 1] - to_e
            apart2 = dn * dn + de * de
            if apart2 < nearest2:
                nearest, nearest2 = k, apart2
        apart = math.sqrt(nearest2)
        if apart < 1e-9:
            continue
        share = min(1.0, p.step_m / apart)
        n, e = nodes[nearest, 0], nodes[nearest, 1]
        to_n, to_e = n + share * (to_n - n), e + share * (to_e - e)
        if is_barred(discs, n, e, to_n, to_e):
            continue
        row = p.count
        nodes[row, 0], nodes[row, 1], nodes[row, 2] = to_n, to_e, nearest
        nodes[row, 3] = nodes[nearest, 3] + share * apart
        p.count += 1
        best = nodes[p.nearest]
        if math.hypot(to_n - p.goal_n, to_e - p.goal_e) < math.hypot(best[0] - p.goal_n, best[1] - p.goal_e):
            p.nearest = row
        if p.found < 0 and p.stops == 1 and not is_barred(discs, to_n, to_e, p.goal_n, p.goal_e):
            p.found = row


class Tree:
    """One search. The same arguments and calls give the same tree."""

    def __init__(
        self,
        root_m: tuple[float, float],
        goal_m: tuple[float, float],
        box_m: tuple[float, float, float, float],
        step_m: float,
        nodes_max: int,
        seed: int,
        stops: bool = True,
    ) -> None:
        """box_m: least north, least east, greatest north, greatest east of the samples. stops: at the first sight of the goal."""
        self.nodes = np.zeros((nodes_max, NODE_COLUMNS))
        self.nodes[0] = *root_m, -1.0, 0.0
        self._progress = np.zeros(1, PROGRESS)
        mixed = (seed * 0x9E3779B97F4A7C15 + 0xD1B54A32D192ED03) % 2**64
        self._progress[0] = (1, 0, -1, 0, mixed or 1, *goal_m, *box_m, step_m, stops)
        self._tries_max = 4 * nodes_max

    def grow(self, discs: Array, tries: int) -> None:
        """Go on, by at most `tries` samples. discs: (m, >=3) float64, row by row."""
        grow(discs, self._progress, self.nodes, tries)

    @property
    def count(self) -> int:
        return int(self._progress[0]["count"])

    @property
    def has_found(self) -> bool:
        return int(self._progress[0]["found"]) >= 0

    @property
    def is_exhausted(self) -> bool:
        """Nothing more will come of it."""
        return self.count >= len(self.nodes) or int(self._progress[0]["tries"]) >= self._tries_max

    def way(self) -> list[tuple[float, float]]:
        """From the root to the node that sees the goal, or where none does to the one nearest to it."""
        found = int(self._progress[0]["found"])
        return self.way_to(found if found >= 0 else int(self._progress[0]["nearest"]))

    def way_to(self, row: int) -> list[tuple[float, float]]:
        """From the root to a node."""
        way = []
        while row >= 0:
            way.append((float(self.nodes[row, 0]), float(self.nodes[row, 1])))
            row = int(self.nodes[row, 2])
        return way[::-1]
