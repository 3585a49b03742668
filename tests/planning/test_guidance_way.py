"""The search for a way past discs, against the same grid searched by SciPy, and against the discs themselves."""

from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from flightapp.core.types import Array
from flightapp.planning.ac2f.corridor import blocking_disc, is_in_group
from flightapp.planning.ac2f.escape import find_way
from flightapp.planning.ac2f.grid_search import CLOSE, SOLID, START, draw_ground, search_ground
from flightapp.planning.ac2f.recollection import CELLS, SIDE, blank_recollection
from flightapp.sim.batch.shortest_path import shortest_path_m

KEEP_M = 0.6
CELL_M = 0.5
ROOM = blank_recollection()
fields = st.lists(st.tuples(st.floats(-15, 15), st.floats(-15, 15), st.floats(0.2, 2.0)), min_size=0, max_size=40)
goals = st.tuples(st.floats(-28, 28), st.floats(-28, 28))


def rows_of(field: list[tuple[float, float, float]], apart_m: float = 0.0) -> Array:
    """The discs that are at least `apart_m` clear of the origin."""
    return np.array([row for row in field if math.hypot(row[0], row[1]) - row[2] > apart_m], dtype=np.float64).reshape(-1, 3)


def way(rows: Array, goal: tuple[float, float], margin_m: float = 0.0) -> tuple[list[tuple[float, float]], float]:
    count = find_way(rows, len(rows), 0.0, 0.0, *goal, KEEP_M, margin_m, CELL_M, ROOM)
    return [(float(n), float(e)) for n, e in ROOM["found"][0, :count]], float(ROOM["found_m"][0])


def nearest_m(rows: Array, a: tuple[float, float], b: tuple[float, float]) -> float:
    """Distance of the segment a-b from the surface of the nearest disc."""
    if not len(rows):
        return math.inf
    start, step = np.array(a), np.array(b) - np.array(a)
    offset = rows[:, :2] - start
    share = np.clip(offset @ step / max(float(step @ step), 1e-12), 0.0, 1.0)
    return float((np.hypot(*(offset - share[:, None] * step).T) - rows[:, 2]).min())


@settings(max_examples=80)
@given(fields, goals, st.sampled_from([0.0, 0.3]))
def test_the_way_keeps_clear_of_every_disc_and_leads_to_the_goal(
    field: list[tuple[float, float, float]], goal: tuple[float, float], margin_m: float
) -> None:
    rows = rows_of(field, KEEP_M + CELL_M)
    corners, length_m = way(rows, goal, margin_m)
    if not corners:
        return
    places = [(0.0, 0.0), *corners]
    for a, b in itertools.pairwise(places):
        assert nearest_m(rows, a, b) >= KEEP_M - (1e-9 if a != (0.0, 0.0) else 0.25)  # the first leg begins beside its cell
    assert math.isclose(length_m, sum(math.dist(a, b) for a, b in itertools.pairwise(places)))
    assert math.dist(corners[-1], goal) <= 6.0 * CELL_M * math.sqrt(2.0) + CELL_M


@settings(max_examples=25)
@given(fields, goals)
def test_the_search_finds_the_cheapest_way_of_its_grid(
    field: list[tuple[float, float, float]], goal: tuple[float, float]
) -> None:
    rows = rows_of(field, 0.5)
    draw_ground(rows, len(rows), 0.0, 0.0, KEEP_M, 0.3, CELL_M, ROOM)
    ground = ROOM["ground"][0].copy()
    cell = int((goal[0] - ROOM["low_n"][0]) // CELL_M) * SIDE + int((goal[1] - ROOM["low_e"][0]) // CELL_M)
    cost = search_ground(ROOM, cell)
    expected = reference_cost(ground, cell)
    assert cost == (expected if math.isfinite(expected) else -1)


def reference_cost(ground: Array, cell: int) -> float:
    """Dijkstra over all steps between cells that are not solid."""
    solid, close = (ground & SOLID) > 0, (ground & CLOSE) > 0
    grid = np.arange(CELLS).reshape(SIDE, SIDE)
    starts, ends, costs = [], [], []
    for dn in (-1, 0, 1):
        for de in (-1, 0, 1):
            a = grid[1:-1, 1:-1].ravel()
            b = grid[1 + dn : SIDE - 1 + dn, 1 + de : SIDE - 1 + de].ravel()
            free = ~solid[a] & ~solid[b] & (a != b)
            plain, near = (17, 26) if dn and de else (12, 18)
            starts.append(a[free])
            ends.append(b[free])
            costs.append(np.where(close[b[free]], near, plain))
    graph = csr_array((np.concatenate(costs), (np.concatenate(starts), np.concatenate(ends))), shape=(CELLS, CELLS))
    return float(dijkstra(graph, indices=START)[cell])


def test_about_as_long_as_the_shortest_way_around_the_discs() -> None:
    random = np.random.default_rng(4)
    for _ in range(10):
        spread = random.uniform(-14.0, 14.0, (25, 2))
        rows = rows_of([(float(n), float(e), 0.8) for n, e in spread], KEEP_M + 0.5)
        goal = (22.0, float(random.uniform(-5.0, 5.0)))
        shortest = shortest_path_m((0.0, 0.0), goal, rows, KEEP_M)
        corners, length_m = way(rows, goal)
        assert shortest is not None
        assert corners
        assert 0.98 * shortest <= length_m <= 1.06 * shortest + CELL_M


def test_no_way_out_of_a_closed_ring() -> None:
    ring = np.array([(5.0 * math.cos(a), 5.0 * math.sin(a), 0.5) for a in np.linspace(0.0, 2.0 * math.pi, 40)])
    assert way(ring, (15.0, 0.0))[0] == []
    assert way(ring[3:-3], (15.0, 0.0))[0] != []


def test_a_gap_that_is_too_narrow_holds_discs_together() -> None:
    row = np.array([(5.0, east, 0.5) for east in (0.0, 2.0, 4.0, 6.5)])
    assert is_in_group(row, 4, 0, KEEP_M, 4.0)
    assert not is_in_group(row, 4, 0, KEEP_M, 5.0)  # 2.5 m apart: 1.5 m of gap is passable at 0.6 m
    assert not is_in_group(row, 4, 3, KEEP_M, 1.0)


def test_the_first_disc_in_the_way_bars_it() -> None:
    rows = np.array([(8.0, 0.0, 0.5), (4.0, 0.9, 0.5), (4.0, -5.0, 0.5), (0.2, 0.0, 0.1)])
    assert blocking_disc(rows, 4, 0.0, 0.0, 0.0, 0.0, 20.0, 0.0, 0.5) == 3
    assert blocking_disc(rows, 4, 0.0, 0.0, 0.0, 0.0, 0.0, 20.0, 0.5) == -1  # leads out of the disc around the vehicle
    assert blocking_disc(rows[:3], 3, 0.0, 0.0, 0.0, 0.0, 20.0, 0.0, 0.5) == 1
