"""The shortest way past remembered discs, as a few corners: searched on a grid, pulled tight."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.corridor import blocking_disc
from flightapp.planning.ac2f.grid_search import MIDDLE, draw_ground, free_cell, search_ground, trace_steps
from flightapp.planning.ac2f.recollection import CORNERS, RECOLLECTION_TYPE, SIDE
from flightapp.planning.ac2f.records import NUMBER, ROWS, WHOLE, Record

REACH = MIDDLE - 4  # cells: a goal farther off is searched at this distance
FREE_CELLS = 6  # a goal inside a disc is moved to a free cell within so many


@compiled(WHOLE(ROWS, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, RECOLLECTION_TYPE, WHOLE))
def _pull(
    rows: Array,
    count: int,
    own_n: float,
    own_e: float,
    end_n: float,
    end_e: float,
    distance_m: float,
    margin_m: float,
    cell_m: float,
    recollection: Record,
    steps: int,
) -> int:
    """Keep of the way only the corners from which the next is not seen; its length in the grid."""
    grid = recollection[0]
    at_n = own_n
    at_e = own_e
    grid.found_m = 0.0
    corners = 0
    at = -1
    while at < steps - 1 or corners == 0:
        next_n = end_n
        next_e = end_e
        seen = at
        keep = distance_m + margin_m
        k = at + 1
        while k < steps:
            last = k == steps - 1
            cell = grid.steps[k]
            n = end_n if last else grid.low_n + (cell // SIDE + 0.5) * cell_m
            e = end_e if last else grid.low_e + (cell % SIDE + 0.5) * cell_m
            free = blocking_disc(rows, count, own_n, own_e, at_n, at_e, n, e, keep) < 0
            if not free and k == at + 1 and keep == distance_m:
                free = True  # neighbouring cells are free by the grid
                n = grid.low_n + (cell // SIDE + 0.5) * cell_m
                e = grid.low_e + (cell % SIDE + 0.5) * cell_m
            if free:
                seen = k
                next_n = n
                next_e = e
                k += 1
            elif seen == at and keep > distance_m:
                keep = distance_m
            else:
                break
        at = max(seen, at + 1)
        grid.found_m += math.hypot(next_n - at_n, next_e - at_e)
        if corners < CORNERS:
            grid.found[corners, 0] = next_n
            grid.found[corners, 1] = next_e
            corners += 1
        at_n = next_n
        at_e = next_e
    return corners


@compiled(WHOLE(ROWS, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, RECOLLECTION_TYPE))
def find_way(
    rows: Array,
    count: int,
    own_n: float,
    own_e: float,
    goal_n: float,
    goal_e: float,
    distance_m: float,
    margin_m: float,
    cell_m: float,
    recollection: Record,
) -> int:
    """Corners of the shortest way own -> goal that keeps `distance_m` from the discs `rows`, into `found`.

    Returns their number, the last being the goal, or where it leads if the goal is too far off or inside a disc; 0 without a
    way. found_m is its length, straight_m the distance of its end.
    """
    grid = recollection[0]
    draw_ground(rows, count, own_n, own_e, distance_m, margin_m, cell_m, recollection)
    off_n = goal_n - own_n
    off_e = goal_e - own_e
    far = max(abs(off_n), abs(off_e))
    share = min(1.0, REACH * cell_m / far) if far > 0.0 else 1.0
    end_n = own_n + share * off_n
    end_e = own_e + share * off_e
    cell = math.floor((end_n - grid.low_n) / cell_m) * SIDE + math.floor((end_e - grid.low_e) / cell_m)
    goal = free_cell(recollection, cell, FREE_CELLS)
    if goal < 0 or search_ground(recollection, goal) < 0:
        return 0
    steps = trace_steps(recollection, goal)
    if steps < 0:
        return 0
    if goal != cell:
        end_n = grid.low_n + (goal // SIDE + 0.5) * cell_m
        end_e = grid.low_e + (goal % SIDE + 0.5) * cell_m
    grid.straight_m = math.hypot(end_n - own_n, end_e - own_e)
    return _pull(rows, count, own_n, own_e, end_n, end_e, distance_m, margin_m, cell_m, recollection, steps)
