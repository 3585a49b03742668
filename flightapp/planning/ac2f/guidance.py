"""Guidance around traps: where a group of discs bars the straight way, fly the corners of the shortest way past them.

The trap is predicted: it needs no confined motion, only remembered discs in the straight way to the goal that reach far enough to
hold the vehicle, and a way past them that is much longer than the straight one. Where the motion is confined all the same, any
way past such discs is flown.
"""

from __future__ import annotations

import math

import numpy as np
from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.corridor import blocking_disc, is_in_group
from flightapp.planning.ac2f.escape import find_way
from flightapp.planning.ac2f.recollection import RECOLLECTION_TYPE
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

REACHED_M = 0.7
FREE_S = 0.2  # the straight way is free for this long: it is over
RENEW_S = 0.1  # the way is barred by a disc that was not known: a new one is searched after this
KEPT_SHARE = 0.9
KEPT_M = 1.0  # another way than the one that is flown must be shorter than this share of it and by this much
ENDED_SHARE = 0.25  # of the detour that begins it
TOUCH_M = 0.05  # a way that touches a disc by less is not barred: discs are seen with noise


@compiled(NUMBER(ROWS, WHOLE, VIEW_TYPE, NUMBER, NUMBER, ROWS, WHOLE, WHOLE, NUMBER))
def _rest_m(
    rows: Array, count: int, view: Record, goal_n: float, goal_e: float, way: Array, corners: int, corner: int, keep_m: float
) -> float:
    """Length of the way from the own position over the corners from `corner` on to the goal; inf where discs bar it."""
    own_n = view[0].own_n
    own_e = view[0].own_e
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


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, NUMBER, NUMBER, RECOLLECTION_TYPE))
def _renew(
    parameters: Record,
    memory: Record,
    view: Record,
    goal_n: float,
    goal_e: float,
    recollection: Record,
) -> None:
    """Search a way; begin, go on with the old or a new one, or end."""
    p = parameters[0]
    m = memory[0]
    v = view[0]
    room = recollection[0]
    rows = room.discs[:]
    way = room.way[:]
    found = room.found[:]
    count = m.disc_count
    m.guidance_next_s = v.t_s + p.guidance_period_s
    corners = find_way(
        rows,
        count,
        v.own_n,
        v.own_e,
        goal_n,
        goal_e,
        p.inflation_m,
        p.guidance_margin_m,
        p.guidance_cell_m,
        recollection,
    )
    if corners == 0:
        m.guided = 0
        m.guidance_next_s = v.t_s + p.guidance_pause_s
        return
    least = p.guidance_detour_m
    if m.guided or m.trapped:
        least *= ENDED_SHARE
    length = room.found_m
    if length - room.straight_m < least:
        m.guided = 0
        return
    if m.guided:
        keep_m = p.inflation_m - TOUCH_M
        to_n = found[corners - 1, 0]
        to_e = found[corners - 1, 1]
        rest = _rest_m(rows, count, view, to_n, to_e, way, m.way_count, m.way_next, keep_m)
        if length > min(KEPT_SHARE * rest, rest - KEPT_M):
            way[m.way_count - 1, 0] = to_n
            way[m.way_count - 1, 1] = to_e
            return
    else:
        m.guided = 1
        m.guided_since_s = v.t_s
        m.guidance_free_s = np.inf
    m.way_count = corners
    m.way_next = 0
    for k in range(corners):  # at once it would take seconds to compile, for its check of the shapes
        way[k, 0] = found[k, 0]
        way[k, 1] = found[k, 1]


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, TRUTH, ROWS, ROWS))
def _go_on(parameters: Record, memory: Record, view: Record, free: bool, rows: Array, way: Array) -> None:
    """The next corner once it is in sight or this one is reached; the end once the straight way is free or the time is over."""
    p = parameters[0]
    m = memory[0]
    v = view[0]
    if v.t_s - m.guided_since_s > p.guidance_time_max_s:
        m.guided = 0
        m.guidance_next_s = v.t_s + p.guidance_pause_s
        return
    m.guidance_free_s = min(m.guidance_free_s, v.t_s) if free else np.inf
    if v.t_s - m.guidance_free_s >= FREE_S:
        m.guided = 0
        return
    own_n = v.own_n
    own_e = v.own_e
    keep_m = p.inflation_m + 0.5 * p.guidance_margin_m
    while m.way_next < m.way_count - 1:
        k = m.way_next
        reached = math.hypot(way[k, 0] - own_n, way[k, 1] - own_e) < REACHED_M
        n = way[k + 1, 0]
        e = way[k + 1, 1]
        if not reached and blocking_disc(rows, m.disc_count, own_n, own_e, own_n, own_e, n, e, keep_m) >= 0:
            break
        m.way_next += 1
    k = m.way_next
    keep_m = p.inflation_m - TOUCH_M
    if blocking_disc(rows, m.disc_count, own_n, own_e, own_n, own_e, way[k, 0], way[k, 1], keep_m) >= 0:
        m.guidance_next_s = min(m.guidance_next_s, v.t_s + RENEW_S)


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, INTENT_TYPE, RECOLLECTION_TYPE))
def guide(parameters: Record, memory: Record, view: Record, intent: Record, recollection: Record) -> None:
    """Where the straight way to the goal of `intent` is a trap, put the guidance point in its place, at full speed.

    The disc memory and the way that is flown are in `recollection`; m.way_next is the corner of the guidance point.
    """
    p = parameters[0]
    m = memory[0]
    v = view[0]
    i = intent[0]
    rows = recollection[0].discs[:]
    way = recollection[0].way[:]
    if not p.guidance:
        return
    own_n = v.own_n
    own_e = v.own_e
    goal_n = i.goal_n
    goal_e = i.goal_e
    keep_m = p.inflation_m + (0.5 * p.guidance_margin_m if m.guided else 0.0)
    first = blocking_disc(rows, m.disc_count, own_n, own_e, own_n, own_e, goal_n, goal_e, keep_m)
    if m.guided:
        _go_on(parameters, memory, view, first < 0, rows, way)
        if m.guided and v.t_s >= m.guidance_next_s:
            _renew(parameters, memory, view, goal_n, goal_e, recollection)
    elif first >= 0 and v.t_s >= m.guidance_next_s:
        if is_in_group(rows, m.disc_count, first, p.inflation_m, p.guidance_group_m):
            _renew(parameters, memory, view, goal_n, goal_e, recollection)
        else:
            m.guidance_next_s = v.t_s + RENEW_S
    if not m.guided:
        return
    n = way[m.way_next, 0]
    e = way[m.way_next, 1]
    distance = math.hypot(n - own_n, e - own_e)
    i.goal_n = n
    i.goal_e = e
    if distance > 0.0:
        i.velocity_n = p.speed_max_m_s * (n - own_n) / distance
        i.velocity_e = p.speed_max_m_s * (e - own_e) / distance
