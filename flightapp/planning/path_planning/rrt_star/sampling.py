"""Where the tree is to grow next: anywhere, or only where a shorter way can lead; pushed away from bodies."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.path_planning.rrt_star.question import QUESTION, Question
from flightapp.space.bodies import BODIES, NUMBER
from flightapp.space.broad_phase import CELLS, Cells, cell_of
from flightapp.space.distance import body_gap

PLACE = numba.types.UniTuple(NUMBER, 3)  # type: ignore[no-untyped-call]
GAP_MIN_M = 0.2
"""Nearer than this the push grows no more."""
Place = tuple[float, float, float]


@compiled(PLACE(QUESTION, NUMBER, NUMBER, NUMBER, NUMBER))
def informed_place(q: Question, length_m: float, one: float, two: float, three: float) -> Place:
    """A place within the ellipsoid of all ways from start to goal no longer than `length_m`, from three numbers in [0, 1)."""
    n, e, d = q.goal_n - q.start_n, q.goal_e - q.start_e, q.goal_d - q.start_d
    direct = math.sqrt(n * n + e * e + d * d)
    n, e, d = n / direct, e / direct, d / direct
    along = 0.5 * length_m
    across = 0.5 * math.sqrt(max(0.0, length_m * length_m - direct * direct))
    height, turn, radius = 2.0 * one - 1.0, 2.0 * math.pi * two, three ** (1.0 / 3.0)
    flat = math.sqrt(max(0.0, 1.0 - height * height))
    x, y, z = along * radius * height, across * radius * flat * math.cos(turn), across * radius * flat * math.sin(turn)
    if abs(d) < 0.9:  # two unit vectors across the way: the first is level
        level = math.sqrt(n * n + e * e)
        a_n, a_e, a_d = -e / level, n / level, 0.0
    else:
        level = math.sqrt(e * e + d * d)
        a_n, a_e, a_d = 0.0, -d / level, e / level
    b_n, b_e, b_d = e * a_d - d * a_e, d * a_n - n * a_d, n * a_e - e * a_n
    return (
        0.5 * (q.start_n + q.goal_n) + x * n + y * a_n + z * b_n,
        0.5 * (q.start_e + q.goal_e) + x * e + y * a_e + z * b_e,
        0.5 * (q.start_d + q.goal_d) + x * d + y * a_d + z * b_d,
    )


@compiled(PLACE(BODIES, CELLS, QUESTION, NUMBER, NUMBER, NUMBER))
def pushed(bodies: Array, cells: Cells, q: Question, n: float, e: float, d: float) -> Place:
    """The sample moved by the potential field of the bodies around it, by no more than a step of the tree.

    A sample inside an inflated body is put on its surface first. The force of a body at gap g is eta (1/g - 1/reach) / g^2
    along the gradient of its signed distance, and zero beyond the reach (section 2.3.1).
    """
    force_n = force_e = force_d = 0.0
    out_n = out_e = out_d = 0.0
    deepest = 0.0
    k = cell_of(cells, n, e)
    if k >= 0:
        for place in range(cells.first[k], cells.first[k + 1]):
            gap, gn, ge, gd = body_gap(bodies, cells.bodies[place], n, e, d)
            gap -= q.gap_m
            if gap < deepest:
                deepest, out_n, out_e, out_d = gap, -gap * gn, -gap * ge, -gap * gd
            if gap < q.push_reach_m:
                near = max(gap, GAP_MIN_M)
                force = q.push_gain * (1.0 / near - 1.0 / q.push_reach_m) / (near * near)
                force_n += force * gn
                force_e += force * ge
                force_d += force * gd
    force = math.sqrt(force_n * force_n + force_e * force_e + force_d * force_d)
    share = min(q.push_share * force, q.step_m) / force if force > 0.0 else 0.0
    return (
        min(q.high_n, max(q.low_n, n + out_n + share * force_n)),
        min(q.high_e, max(q.low_e, e + out_e + share * force_e)),
        min(q.high_d, max(q.low_d, d + out_d + share * force_d)),
    )
