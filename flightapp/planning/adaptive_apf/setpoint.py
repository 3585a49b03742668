"""From the velocity that the field asks for to one that the vehicle can be given: limits of change, and the safety filter."""

from __future__ import annotations

import math

import numba
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.space.bodies import BODIES, INDICES, NUMBER, ROW, V_DOWN, V_EAST, V_NORTH, WHOLE

SWEEPS = 20
BARRIER, BRAKING = 1.0, 2.0
STANDING_M_S = 1e-3


@compiled(numba.void(ROW, ROW, NUMBER))
def limit_turn(wanted: Array, before: Array, turn_max_rad: float) -> None:
    """Turn `wanted` (3,) so that its course is at most `turn_max_rad` from that of `before`, slower by the cosine of the rest."""
    speed = math.sqrt(wanted[0] ** 2 + wanted[1] ** 2 + wanted[2] ** 2)
    old = math.sqrt(before[0] ** 2 + before[1] ** 2 + before[2] ** 2)
    if speed < STANDING_M_S or old < STANDING_M_S:
        return
    n, e, d = before[0] / old, before[1] / old, before[2] / old
    cosine = (wanted[0] * n + wanted[1] * e + wanted[2] * d) / speed
    angle = math.acos(min(1.0, max(-1.0, cosine)))
    if angle <= turn_max_rad:
        return
    an, ae, ad = wanted[0] / speed - cosine * n, wanted[1] / speed - cosine * e, wanted[2] / speed - cosine * d
    across = math.sqrt(an * an + ae * ae + ad * ad)
    if across < 1e-9:  # straight back: to the right, in the plane
        level = math.sqrt(n * n + e * e)
        if level < 1e-9:
            an, ae, ad = 1.0, 0.0, 0.0
        else:
            an, ae, ad = -e / level, n / level, 0.0
        across = 1.0
    kept = speed * max(0.0, math.cos(angle - turn_max_rad))
    c, s = kept * math.cos(turn_max_rad), kept * math.sin(turn_max_rad) / across
    wanted[0], wanted[1], wanted[2] = c * n + s * an, c * e + s * ae, c * d + s * ad


@compiled(numba.void(ROW, ROW, NUMBER))
def limit_change(wanted: Array, before: Array, change_max_m_s: float) -> None:
    """Bring `wanted` (3,) within `change_max_m_s` of `before`; what brakes comes first."""
    cn, ce, cd = wanted[0] - before[0], wanted[1] - before[1], wanted[2] - before[2]
    change = math.sqrt(cn * cn + ce * ce + cd * cd)
    if change <= change_max_m_s:
        return
    old = math.sqrt(before[0] ** 2 + before[1] ** 2 + before[2] ** 2)
    along = 0.0
    if old > STANDING_M_S:
        along = (cn * before[0] + ce * before[1] + cd * before[2]) / old
    if along >= 0.0:
        share = change_max_m_s / change
        wanted[0], wanted[1], wanted[2] = before[0] + share * cn, before[1] + share * ce, before[2] + share * cd
        return
    n, e, d = before[0] / old, before[1] / old, before[2] / old
    an, ae, ad = cn - along * n, ce - along * e, cd - along * d
    along = max(along, -change_max_m_s)
    left = math.sqrt(max(0.0, change_max_m_s * change_max_m_s - along * along))
    across = math.sqrt(an * an + ae * ae + ad * ad)
    share = min(1.0, left / across) if across > 0.0 else 0.0
    wanted[0] = before[0] + along * n + share * an
    wanted[1] = before[1] + along * e + share * ae
    wanted[2] = before[2] + along * d + share * ad


@compiled(NUMBER(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def closing_max_m_s(room_m: float, form: float, alpha_1_s: float, deceleration_m_s2: float, reaction_s: float) -> float:
    """How fast a body may be neared with `room_m` to the margin left; within it, how fast it must be left (negative)."""
    if room_m <= 0.0:
        return alpha_1_s * room_m
    if form == BARRIER:
        return alpha_1_s * room_m
    return float(braking_speed_m_s(room_m, deceleration_m_s2, reaction_s))


@compiled(numba.boolean(BODIES, INDICES, BODIES, WHOLE, ROW, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, ROW))
def filter_velocity(
    bodies: Array,
    which: NDArray,  # type: ignore[type-arg]
    gaps: Array,
    count: int,
    velocity: Array,
    kept_m: float,
    form: float,
    alpha_1_s: float,
    deceleration_m_s2: float,
    reaction_s: float,
    shares: Array,
) -> bool:
    """Change `velocity` (3,) least so that no body is neared faster than its room allows; whether anything had to change.

    gaps as `nearest_bodies` has them, kept_m: from the vehicle's centre. shares (>= count,) is room for Dykstra's corrections.
    Where the conditions contradict each other the last sweep stands: it satisfies the nearest body's condition, which comes last.
    """
    changed = False
    for j in range(count):
        shares[j] = 0.0
    for _ in range(SWEEPS):
        moved = 0.0
        for back in range(count):
            j = count - 1 - back
            k = which[j]
            n, e, d = gaps[j, 1], gaps[j, 2], gaps[j, 3]
            allowed = closing_max_m_s(gaps[j, 0] - kept_m, form, alpha_1_s, deceleration_m_s2, reaction_s)
            leaving = n * (velocity[0] - bodies[k, V_NORTH]) + e * (velocity[1] - bodies[k, V_EAST])
            leaving += d * (velocity[2] - bodies[k, V_DOWN])
            share = max(0.0, shares[j] - allowed - leaving)
            step = share - shares[j]
            if step != 0.0:
                velocity[0], velocity[1], velocity[2] = velocity[0] + step * n, velocity[1] + step * e, velocity[2] + step * d
                shares[j] = share
                moved = max(moved, abs(step))
                changed = True
        if moved < 1e-9:
            break
    return changed
