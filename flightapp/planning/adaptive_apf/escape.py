"""Module B: notice that the vehicle is trapped, and push it sideways (section 2.4)."""

from __future__ import annotations

import math

import numba
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.adaptive_apf.forces import VECTOR, Vector
from flightapp.space.bodies import BODIES, INDICES, NUMBER, ROW, WHOLE
from flightapp.space.distance import body_gap

TEST_PERIOD_S = 0.2
PAST = 6
"""Places kept, one a test: the first is 1 s before the last."""
HITS, HITS_OPEN = 5, 10
"""More consecutive hits mean a trap; so many also where the straight way is free."""
PROGRESS_SHARE = 0.3
TRIES = 3
FORCE_SHARE = 1.5
"""Of the attraction."""
HOLD_MIN_S, HOLD_MAX_S = 0.5, 3.0
GROWTH = 1.5
STEP_M = 0.02

NEXT, COUNT, TESTED, UNTIL, PUSH_N, PUSH_E, PUSH_D, TRIED = range(8)
TRAP_SIZE = 8
"""What is remembered: when the next test is due, consecutive hits, places noted, until when the push lasts, its direction, how
often it was tried in a row."""


@compiled(VECTOR(*(NUMBER,) * 3, *(NUMBER,) * 3, *(NUMBER,) * 3, NUMBER))
def escape_direction(
    push_n: float,
    push_e: float,
    push_d: float,
    ahead_n: float,
    ahead_e: float,
    ahead_d: float,
    one: float,
    two: float,
    three: float,
    spread: float,
) -> Vector:
    """Unit vector across the way ahead: along the summed repulsion `push`, with a random part from a Gaussian (one, two, three).

    Where the push comes head-on all directions across are as good.
    """
    size = math.sqrt(push_n * push_n + push_e * push_e + push_d * push_d)
    length = math.sqrt(ahead_n * ahead_n + ahead_e * ahead_e + ahead_d * ahead_d)
    if length > 0.0:
        ahead_n, ahead_e, ahead_d = ahead_n / length, ahead_e / length, ahead_d / length
    if size > 0.0:
        push_n, push_e, push_d = push_n / size, push_e / size, push_d / size
    along = push_n * ahead_n + push_e * ahead_e + push_d * ahead_d
    n, e, d = push_n - along * ahead_n, push_e - along * ahead_e, push_d - along * ahead_d
    if math.sqrt(n * n + e * e + d * d) < 0.1:
        spread = max(spread, 1.0)
    along = one * ahead_n + two * ahead_e + three * ahead_d
    one, two, three = one - along * ahead_n, two - along * ahead_e, three - along * ahead_d
    random = math.sqrt(one * one + two * two + three * three)
    if random > 1e-9:
        n, e, d = n + spread * one / random, e + spread * two / random, d + spread * three / random
    size = math.sqrt(n * n + e * e + d * d)
    if size < 1e-9:
        return 0.0, 0.0, 0.0
    return n / size, e / size, d / size


@compiled(NUMBER(BODIES, INDICES, WHOLE, ROW, ROW, NUMBER))
def barred_by_m(bodies: Array, which: NDArray, count: int, place: Array, goal: Array, radius_m: float) -> float:  # type: ignore[type-arg]
    """How far along the straight way to `goal` a ball first overlaps a body where that is now; -1: nowhere (sphere tracing)."""
    n, e, d = goal[0] - place[0], goal[1] - place[1], goal[2] - place[2]
    length = math.sqrt(n * n + e * e + d * d)
    first = math.inf
    for j in range(count):
        way = 0.0
        while way < min(length, first):
            share = way / length
            gap = body_gap(bodies, which[j], place[0] + share * n, place[1] + share * e, place[2] + share * d)[0] - radius_m
            if gap < 0.0:
                first = way
            way += max(gap, STEP_M)
    return first if first < math.inf else -1.0


@compiled(numba.boolean(ROW, BODIES, BODIES, INDICES, WHOLE, ROW, ROW, NUMBER, NUMBER, NUMBER, NUMBER))
def is_trapped(
    trap: Array,
    past: Array,
    bodies: Array,
    which: NDArray,  # type: ignore[type-arg]
    count: int,
    place: Array,
    goal: Array,
    radius_m: float,
    speed_m_s: float,
    tolerance_m: float,
    t_s: float,
) -> bool:
    """Whether the vehicle hardly moved and its way is barred, test after test; past (PAST, 3), trap (TRAP_SIZE,) remember."""
    if t_s < trap[NEXT] - 1e-9 or t_s <= trap[UNTIL]:
        return False
    trap[NEXT] = t_s + TEST_PERIOD_S
    for k in range(PAST - 1):
        past[k, 0], past[k, 1], past[k, 2] = past[k + 1, 0], past[k + 1, 1], past[k + 1, 2]
    past[PAST - 1, 0], past[PAST - 1, 1], past[PAST - 1, 2] = place[0], place[1], place[2]
    trap[TESTED] += 1.0
    if trap[TESTED] < PAST:
        return False
    n, e, d = place[0] - past[0, 0], place[1] - past[0, 1], place[2] - past[0, 2]
    moved = math.sqrt(n * n + e * e + d * d)
    n, e, d = goal[0] - place[0], goal[1] - place[1], goal[2] - place[2]
    far = math.sqrt(n * n + e * e + d * d) > 3.0 * tolerance_m
    if not far or moved >= PROGRESS_SHARE * speed_m_s:
        trap[COUNT] = 0.0
        if moved >= 2.0 * PROGRESS_SHARE * speed_m_s:
            trap[TRIED] = 0.0
        return False
    trap[COUNT] += 1.0
    if trap[COUNT] <= HITS:
        return False
    return bool(trap[COUNT] > HITS_OPEN or barred_by_m(bodies, which, count, place, goal, radius_m) >= 0.0)


@compiled(numba.void(ROW, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def begin_escape(trap: Array, n: float, e: float, d: float, hold_s: float, t_s: float) -> None:
    """Push along (n, e, d) for about `hold_s`; again from the same trap: to the same side, and longer."""
    if trap[TRIED] == 0.0:
        trap[PUSH_N], trap[PUSH_E], trap[PUSH_D] = n, e, d
    trap[UNTIL] = t_s + min(HOLD_MAX_S, max(HOLD_MIN_S, hold_s)) * GROWTH ** trap[TRIED]
    trap[TRIED] += 1.0
    trap[COUNT] = 0.0
    trap[TESTED] = 0.0


def forget(trap: Array) -> None:
    """Nothing is near that could trap: end the push, and count from the beginning."""
    trap[COUNT] = trap[TESTED] = trap[UNTIL] = trap[TRIED] = 0.0
