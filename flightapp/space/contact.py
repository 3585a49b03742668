"""When something that flies straight on first touches something that moves straight on: conservative advancement."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.space.bodies import BODIES, NUMBER, V_DOWN, V_EAST, V_NORTH
from flightapp.space.distance import body_gap

TOUCHING_M = 1e-4
"""Nearer than this counts as contact: what is reported comes this much of a way too early, never too late."""
NEVER = math.inf
CONTACT = numba.types.Tuple((numba.float64, numba.int64))  # type: ignore[no-untyped-call]


@compiled(CONTACT(BODIES, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def first_contact(
    bodies: Array,
    north: float,
    east: float,
    down: float,
    vn: float,
    ve: float,
    vd: float,
    start_s: float,
    radius_m: float,
    horizon_s: float,
) -> tuple[float, int]:
    """(s after the start, row of the body) at which a ball of `radius_m` first touches one; (NEVER, -1) not within `horizon_s`.

    The ball is at the point at `start_s` and flies with (vn, ve, vd), every body with its own velocity. The signed distance
    changes no faster than the two approach, so time can be advanced by their quotient without missing a contact
    (specification 2.7, stage 4).
    """
    first, which = NEVER, -1
    for i in range(bodies.shape[0]):
        un, ue, ud = vn - bodies[i, V_NORTH], ve - bodies[i, V_EAST], vd - bodies[i, V_DOWN]
        speed = math.sqrt(un * un + ue * ue + ud * ud)
        moved_n, moved_e, moved_d = bodies[i, V_NORTH] * start_s, bodies[i, V_EAST] * start_s, bodies[i, V_DOWN] * start_s
        begin_n, begin_e, begin_d = north - moved_n, east - moved_e, down - moved_d
        end = min(first, horizon_s)
        t = 0.0
        while t <= end:
            gap = body_gap(bodies, i, begin_n + un * t, begin_e + ue * t, begin_d + ud * t)[0] - radius_m
            if gap <= TOUCHING_M:
                if t < first:
                    first, which = t, i
                break
            if gap > speed * (end - t):
                break
            t += gap / speed
    return first, which
