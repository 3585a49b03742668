"""A* on a grid around the vehicle, over discs; unknown space is free.

Cells are aligned with the mission frame, so that the same discs give the same cells from everywhere. Costs are whole numbers:
12 a straight and 17 a diagonal step (0.2 % more than sqrt(2)), half as much again close to a disc. The open list is an array of
stacks, one for each total cost, used as a ring, because one step adds at most 26 + 17, less than `RING`, to the total cost.
"""

from __future__ import annotations

import math

from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.corridor import kept_m
from flightapp.planning.ac2f.recollection import CELLS, OPEN, RECOLLECTION_TYPE, RING, SIDE, STEPS
from flightapp.planning.ac2f.records import NUMBER, ROWS, WHOLE, Record

MIDDLE = SIDE // 2
START = MIDDLE * SIDE + MIDDLE
STRAIGHT, DIAGONAL = 12, 17
STRAIGHT_CLOSE, DIAGONAL_CLOSE = 18, 26
FREE, CLOSE, SOLID, DONE = 0, 1, 2, 4
UNREACHED = 2**30


@compiled(void(ROWS, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, RECOLLECTION_TYPE))
def draw_ground(
    rows: Array, count: int, own_n: float, own_e: float, distance_m: float, margin_m: float, cell_m: float, recollection: Record
) -> None:
    """Fill the grid around the own position: solid, close to a disc, or free.

    Solid so far around a disc that no straight line between neighbouring cells that are not comes nearer than `distance_m`.
    """
    grid = recollection[0]
    ground = grid.ground
    grid.low_n = (math.floor(own_n / cell_m) - MIDDLE) * cell_m
    grid.low_e = (math.floor(own_e / cell_m) - MIDDLE) * cell_m
    for c in range(CELLS):
        ground[c] = FREE
    for k in range(SIDE):
        ground[k] = ground[CELLS - 1 - k] = ground[k * SIDE] = ground[k * SIDE + SIDE - 1] = SOLID
    for i in range(count):
        keep = kept_m(rows, i, own_n, own_e, distance_m)
        solid2 = keep * keep + 0.5 * cell_m * cell_m
        near = keep + margin_m
        near2 = near * near + 0.5 * cell_m * cell_m
        reach = math.sqrt(near2) / cell_m
        at_n = (rows[i, 0] - grid.low_n) / cell_m - 0.5
        at_e = (rows[i, 1] - grid.low_e) / cell_m - 0.5
        if not (-reach < at_n < SIDE + reach and -reach < at_e < SIDE + reach):
            continue
        for a in range(max(1, math.ceil(at_n - reach)), min(SIDE - 2, math.floor(at_n + reach)) + 1):
            dn = (a - at_n) * cell_m
            for b in range(max(1, math.ceil(at_e - reach)), min(SIDE - 2, math.floor(at_e + reach)) + 1):
                de = (b - at_e) * cell_m
                apart2 = dn * dn + de * de
                if apart2 < solid2:
                    ground[a * SIDE + b] = SOLID
                elif apart2 < near2:
                    ground[a * SIDE + b] |= CLOSE
    ground[MIDDLE * SIDE + MIDDLE] = FREE


@compiled("i8(i8,i8,i8,i8)")
def _least_cost(n: int, e: int, goal_n: int, goal_e: int) -> int:
    dn = abs(goal_n - n)
    de = abs(goal_e - e)
    return STRAIGHT * max(dn, de) + (DIAGONAL - STRAIGHT) * min(dn, de)


@compiled(WHOLE(RECOLLECTION_TYPE, WHOLE))
def search_ground(recollection: Record, goal: int) -> int:
    """Cost of the cheapest way from the middle of the grid to the cell `goal`, whose steps are left in `came`; -1: none."""
    grid = recollection[0]
    ground = grid.ground
    cost = grid.cost
    came = grid.came
    ring = grid.ring
    open_cell = grid.open_cell
    open_next = grid.open_next
    goal_n = goal // SIDE
    goal_e = goal % SIDE
    for c in range(CELLS):
        cost[c] = UNREACHED
    for k in range(RING):
        ring[k] = -1
    cost[START] = 0
    came[START] = START
    total = _least_cost(MIDDLE, MIDDLE, goal_n, goal_e)
    ring[total % RING] = 0
    open_cell[0] = START
    open_next[0] = -1
    used = 1
    waiting = 1
    while waiting > 0:
        entry = ring[total % RING]
        if entry < 0:
            total += 1
            continue
        ring[total % RING] = open_next[entry]
        waiting -= 1
        c = open_cell[entry]
        if ground[c] & DONE:
            continue
        ground[c] |= DONE
        if c == goal:
            break
        cn = c // SIDE
        ce = c % SIDE
        for dn in range(-1, 2):
            for de in range(-1, 2):
                other = c + dn * SIDE + de
                if ground[other] & (SOLID | DONE):
                    continue
                if dn != 0 and de != 0:
                    step = DIAGONAL_CLOSE if ground[other] & CLOSE else DIAGONAL
                else:
                    step = STRAIGHT_CLOSE if ground[other] & CLOSE else STRAIGHT
                there = cost[c] + step
                if there >= cost[other]:
                    continue
                if used == OPEN:
                    return -1
                cost[other] = there
                came[other] = c
                bucket = (there + _least_cost(cn + dn, ce + de, goal_n, goal_e)) % RING
                open_cell[used] = other
                open_next[used] = ring[bucket]
                ring[bucket] = used
                used += 1
                waiting += 1
    found: int = cost[goal] if ground[goal] & DONE else -1
    return found


@compiled(WHOLE(RECOLLECTION_TYPE, WHOLE))
def trace_steps(recollection: Record, goal: int) -> int:
    """Cells of the way into `steps`, from the one after the start to `goal`; their number, -1 where they are too many."""
    came = recollection[0].came
    steps = recollection[0].steps
    count = 0
    c = goal
    while came[c] != c:
        if count == STEPS:
            return -1
        steps[count] = c
        count += 1
        c = came[c]
    for k in range(count // 2):
        swapped = steps[k]
        steps[k] = steps[count - 1 - k]
        steps[count - 1 - k] = swapped
    return count


@compiled(WHOLE(RECOLLECTION_TYPE, WHOLE, WHOLE))
def free_cell(recollection: Record, cell: int, reach: int) -> int:
    """The cell that is not solid nearest to `cell`, within `reach` cells; -1: none."""
    ground = recollection[0].ground
    if not ground[cell] & SOLID:
        return cell
    best = -1
    best2 = 2 * reach * reach + 1
    cn = cell // SIDE
    ce = cell % SIDE
    for a in range(max(1, cn - reach), min(SIDE - 2, cn + reach) + 1):
        for b in range(max(1, ce - reach), min(SIDE - 2, ce + reach) + 1):
            apart2 = (a - cn) * (a - cn) + (b - ce) * (b - ce)
            if apart2 < best2 and not ground[a * SIDE + b] & SOLID:
                best = a * SIDE + b
                best2 = apart2
    return best
