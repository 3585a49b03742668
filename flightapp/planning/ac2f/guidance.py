"""Guidance around traps: where a group of discs bars the straight way, fly the corners of the shortest way past them.

The trap is predicted: it needs no confined motion, only remembered discs in the straight way to the goal that reach far enough to
hold the vehicle, and a way past them that is much longer than the straight one. Where the motion is confined all the same, any
way past such discs is flown.
"""

from __future__ import annotations

import math

import numpy as np
from numba import void

from flightapp.core.types import Array
from flightapp.planning.ac2f.corridor import blocking_disc, is_in_group
from flightapp.planning.ac2f.escape import find_way
from flightapp.planning.ac2f.grid_search import GRID_TYPE
from flightapp.planning.ac2f.records import (
    INTENT_TYPE,
    MEMORY_TYPE,
    NUMBER,
    PARAMETERS_TYPE,
    ROWS,
    TRUTH,
    VIEW_TYPE,
    WHOLE,
    Record,
)
from flightapp.planning.compiled import compiled

REACHED_M = 0.7
FREE_S = 0.2  # the straight way is free for this long: it is over
RENEW_S = 0.1  # the way is barred by a disc that was not known: a new one is searched after this
KEPT_SHARE = 0.9
KEPT_M = 1.0  # another way than the one that is flown must be shorter than this share of it and by this much
ENDED_SHARE = 0.25  # of the detour that begins it
TOUCH_M = 0.05  # a way that touches a disc by less is not barred: discs are seen with noise


@compiled(NUMBER(ROWS, WHOLE, VIEW_TYPE, NUMBER, NUMBER, ROWS, WHOLE, WHOLE, NUMBER))
def _rest_m(
    rows: Array, count: int, views: Record, goal_n: float, goal_e: float, way: Array, corners: int, corner: int, keep_m: float
) -> float:
    """Length of the way from the own position over the corners from `corner` on to the goal; inf where discs bar it."""
    own_n = views[0].own_n
    own_e = views[0].own_e
    n = own_n
    e = own_e
    length = 0.0
    for k in range(corner, corners):
        last = k == corners - 1
        to_n = goal_n if last else way[k, 0]
        to_e = goal_e if last else way[k, 1]
        if blocking_disc(rows, count, own_n, own_e, n, e, to_n, to_e, keep_m) >= 0:
            return np.inf
        length += math.hypot(to_n - n, to_e - e)
        n = to_n
        e = to_e
    return length


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, NUMBER, NUMBER, ROWS, ROWS, ROWS, GRID_TYPE))
def _renew(
    settings: Record,
    memories: Record,
    views: Record,
    goal_n: float,
    goal_e: float,
    rows: Array,
    way: Array,
    found: Array,
    grids: Record,
) -> None:
    """Search a way; begin, go on with the old or a new one, or end."""
    parameters = settings[0]
    memory = memories[0]
    view = views[0]
    count = memory.disc_count
    memory.guidance_next_s = view.t_s + parameters.guidance_period_s
    corners = find_way(
        rows,
        count,
        view.own_n,
        view.own_e,
        goal_n,
        goal_e,
        parameters.inflation_m,
        parameters.guidance_margin_m,
        parameters.guidance_cell_m,
        grids,
        found,
    )
    if corners == 0:
        memory.guided = 0
        memory.guidance_next_s = view.t_s + parameters.guidance_pause_s
        return
    least = parameters.guidance_detour_m
    if memory.guided or memory.trapped:
        least *= ENDED_SHARE
    length = grids[0].length_m
    if length - grids[0].straight_m < least:
        memory.guided = 0
        return
    if memory.guided:
        keep_m = parameters.inflation_m - TOUCH_M
        to_n = found[corners - 1, 0]
        to_e = found[corners - 1, 1]
        rest = _rest_m(rows, count, views, to_n, to_e, way, memory.way_count, memory.way_next, keep_m)
        if length > min(KEPT_SHARE * rest, rest - KEPT_M):
            way[memory.way_count - 1, 0] = to_n
            way[memory.way_count - 1, 1] = to_e
            return
    else:
        memory.guided = 1
        memory.guided_since_s = view.t_s
        memory.guidance_free_s = np.inf
    memory.way_count = corners
    memory.way_next = 0
    way[:corners] = found[:corners]


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, TRUTH, ROWS, ROWS))
def _go_on(settings: Record, memories: Record, views: Record, free: bool, rows: Array, way: Array) -> None:
    """The next corner once it is in sight or this one is reached; the end once the straight way is free or the time is over."""
    parameters = settings[0]
    memory = memories[0]
    view = views[0]
    if view.t_s - memory.guided_since_s > parameters.guidance_time_max_s:
        memory.guided = 0
        memory.guidance_next_s = view.t_s + parameters.guidance_pause_s
        return
    memory.guidance_free_s = min(memory.guidance_free_s, view.t_s) if free else np.inf
    if view.t_s - memory.guidance_free_s >= FREE_S:
        memory.guided = 0
        return
    own_n = view.own_n
    own_e = view.own_e
    keep_m = parameters.inflation_m + 0.5 * parameters.guidance_margin_m
    while memory.way_next < memory.way_count - 1:
        k = memory.way_next
        reached = math.hypot(way[k, 0] - own_n, way[k, 1] - own_e) < REACHED_M
        n = way[k + 1, 0]
        e = way[k + 1, 1]
        if not reached and blocking_disc(rows, memory.disc_count, own_n, own_e, own_n, own_e, n, e, keep_m) >= 0:
            break
        memory.way_next += 1
    k = memory.way_next
    keep_m = parameters.inflation_m - TOUCH_M
    if blocking_disc(rows, memory.disc_count, own_n, own_e, own_n, own_e, way[k, 0], way[k, 1], keep_m) >= 0:
        memory.guidance_next_s = min(memory.guidance_next_s, view.t_s + RENEW_S)


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, INTENT_TYPE, ROWS, ROWS, ROWS, GRID_TYPE))
def guide(
    settings: Record, memories: Record, views: Record, intents: Record, rows: Array, way: Array, found: Array, grids: Record
) -> None:
    """Where the straight way to the goal of `intents` is a trap, put the guidance point in its place, at full speed.

    rows: the disc memory. way: (CORNERS, 2), what is flown. found: the same, room for the search. memory: guided, way_next.
    """
    parameters = settings[0]
    memory = memories[0]
    view = views[0]
    intent = intents[0]
    if not parameters.guidance:
        return
    own_n = view.own_n
    own_e = view.own_e
    goal_n = intent.goal_n
    goal_e = intent.goal_e
    keep_m = parameters.inflation_m + (0.5 * parameters.guidance_margin_m if memory.guided else 0.0)
    first = blocking_disc(rows, memory.disc_count, own_n, own_e, own_n, own_e, goal_n, goal_e, keep_m)
    if memory.guided:
        _go_on(settings, memories, views, first < 0, rows, way)
        if memory.guided and view.t_s >= memory.guidance_next_s:
            _renew(settings, memories, views, goal_n, goal_e, rows, way, found, grids)
    elif first >= 0 and view.t_s >= memory.guidance_next_s:
        if is_in_group(rows, memory.disc_count, first, parameters.inflation_m, parameters.guidance_group_m):
            _renew(settings, memories, views, goal_n, goal_e, rows, way, found, grids)
        else:
            memory.guidance_next_s = view.t_s + RENEW_S
    if not memory.guided:
        return
    n = way[memory.way_next, 0]
    e = way[memory.way_next, 1]
    distance = math.hypot(n - own_n, e - own_e)
    intent.goal_n = n
    intent.goal_e = e
    if distance > 0.0:
        intent.velocity_n = parameters.speed_max_m_s * (n - own_n) / distance
        intent.velocity_e = parameters.speed_max_m_s * (e - own_e) / distance
