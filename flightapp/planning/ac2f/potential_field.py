"""Reactive avoidance (section 4.2): attraction plus repulsion, and the velocity next to it that can still brake.

The repulsion follows F_j = eta (p - o_j) / |p - o_j| / gap_j^2 within the influence distance; its sum is capped below the
attraction, so that a wall seen as many small discs deflects and never reverses. The command is the velocity nearest to the
wanted one from which the vehicle can still stop before every disc, relative to the disc's own motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.compiled import compiled
from flightapp.planning.plane import Point, limited

DIRECTIONS = 36
SPEEDS = 6
LEAVING_PER_S = 2.0  # speed out of an inflated disc, per metre of depth
LEAVING_MAX_M_S = 1.0
EXCESS_COST = 8.0
ACROSS_COST = 0.3
CHANGE_COST = 0.1
NO_LIMIT_M_S = 1e18
MANOEUVRE_S = 0.2  # a velocity is judged by what this long a change reaches of it, too


@dataclass(frozen=True, slots=True)
class FieldParameters:
    """Gains of the field and what braking may assume."""

    gain_m2: float
    influence_m: float
    repulsion_max: float
    deceleration_m_s2: float
    reaction_s: float


@compiled("void(f8[:,::1],f8,f8,f8,f8,f8[::1])")
def _repulsion(scene: Array, n: float, e: float, gain: float, influence_m: float, out: Array) -> None:
    out[0] = 0.0
    out[1] = 0.0
    for i in range(scene.shape[0]):
        dn = n - scene[i, 0]
        de = e - scene[i, 1]
        distance = math.hypot(dn, de)
        gap = distance - scene[i, 2]
        if gap < influence_m and distance > 1e-9:
            gap = max(gap, 0.1)
            force = gain / (gap * gap) / distance
            out[0] += force * dn
            out[1] += force * de


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8,f8)")
def _excess_m_s(
    scene: Array, n: float, e: float, vn: float, ve: float, deceleration_m_s2: float, reaction_s: float, enough_m_s: float
) -> float:
    """By how much (vn, ve) is too fast towards the worst disc on its way, or too slow out of one; 0 where it is safe.

    Above `enough_m_s` the result is no more than a lower bound.
    """
    excess = 0.0
    for i in range(scene.shape[0]):
        if excess > enough_m_s:
            break
        dn = scene[i, 0] - n
        de = scene[i, 1] - e
        un = vn - scene[i, 3]
        ue = ve - scene[i, 4]
        closing = un * dn + ue * de
        if scene[i, 5] > 0.0:
            outwards = -closing / max(1e-9, math.hypot(dn, de))
            excess = max(excess, min(LEAVING_MAX_M_S, LEAVING_PER_S * scene[i, 5]) - outwards)
        if closing <= 0.0:
            continue
        speed2 = un * un + ue * ue
        radius2 = scene[i, 2] * scene[i, 2]
        miss2 = dn * dn + de * de - closing * closing / speed2
        if miss2 >= radius2:
            continue
        speed = math.sqrt(speed2)
        gap = closing / speed - math.sqrt(radius2 - miss2)
        excess = max(excess, speed - braking_speed_m_s(gap, deceleration_m_s2, reaction_s))
    return excess


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def _risk_m_s(
    scene: Array,
    n: float,
    e: float,
    vn: float,
    ve: float,
    base_n: float,
    base_e: float,
    reach: float,
    deceleration_m_s2: float,
    reaction_s: float,
    enough_m_s: float,
) -> float:
    """Excess of (vn, ve) and of what is reached of it, from the base velocity, within the reaction; as `_excess_m_s`."""
    risk = _excess_m_s(scene, n, e, vn, ve, deceleration_m_s2, reaction_s, enough_m_s)
    change = math.hypot(vn - base_n, ve - base_e)
    if change <= reach or risk > enough_m_s:
        return risk
    part = reach / change
    first_n = base_n + part * (vn - base_n)
    first_e = base_e + part * (ve - base_e)
    return risk + _excess_m_s(scene, n, e, first_n, first_e, deceleration_m_s2, reaction_s, enough_m_s - risk)


@compiled("void(f8[:,::1],f8,f8,f8,f8,f8,f8,f8,f8,f8,f8,f8[::1])")
def _choose(
    scene: Array,
    n: float,
    e: float,
    wish_n: float,
    wish_e: float,
    base_n: float,
    base_e: float,
    speed_max: float,
    reach: float,
    deceleration_m_s2: float,
    reaction_s: float,
    out: Array,
) -> None:
    out[0] = wish_n
    out[1] = wish_e
    risk = _risk_m_s(scene, n, e, wish_n, wish_e, base_n, base_e, reach, deceleration_m_s2, reaction_s, NO_LIMIT_M_S)
    if risk == 0.0:
        return
    wish = math.hypot(wish_n, wish_e)
    heading = math.atan2(wish_e, wish_n) if wish > 1e-9 else 0.0
    unit_n = math.cos(heading)
    unit_e = math.sin(heading)
    best = EXCESS_COST * risk + CHANGE_COST * math.hypot(wish_n - base_n, wish_e - base_e)
    for k in range(DIRECTIONS):
        angle = heading + k * (2.0 * math.pi / DIRECTIONS)
        cos = math.cos(angle)
        sin = math.sin(angle)
        for j in range(SPEEDS):
            speed = wish * 0.5 * (j + 1) if j < 2 else speed_max * 0.25 * (j - 1)
            if k == 0 and j == 1:
                speed = 0.0
            vn = speed * cos
            ve = speed * sin
            ahead = vn * unit_n + ve * unit_e
            across = abs(ve * unit_n - vn * unit_e)
            cost = abs(wish - ahead) + ACROSS_COST * across + CHANGE_COST * math.hypot(vn - base_n, ve - base_e)
            if cost >= best:
                continue
            too_much = (best - cost) / EXCESS_COST * (1.0 + 1e-9)
            risk = _risk_m_s(scene, n, e, vn, ve, base_n, base_e, reach, deceleration_m_s2, reaction_s, too_much)
            cost += EXCESS_COST * risk
            if cost < best:
                best = cost
                out[0] = vn
                out[1] = ve


def deflected(scene: Array, own: Point, wish: Point, field: FieldParameters) -> Point:
    """`wish` (m/s) turned by the repulsion of `scene` (m, 6) at `own` (m), at the same speed."""
    speed = math.hypot(*wish)
    if speed < 1e-6:
        return wish
    force = np.empty(2)
    _repulsion(scene, own[0], own[1], field.gain_m2, field.influence_m, force)
    push = limited((float(force[0]), float(force[1])), field.repulsion_max)
    north, east = wish[0] / speed + push[0], wish[1] / speed + push[1]
    length = math.hypot(north, east)
    return (north * speed / length, east * speed / length) if length > 1e-6 else wish


def safe_velocity(scene: Array, own: Point, wish: Point, base: Point, speed_max_m_s: float, field: FieldParameters) -> Point:
    """The velocity (m/s) nearest to `wish` that can brake before every disc of `scene`; `base` breaks ties against chatter."""
    out = np.empty(2)
    reach = field.deceleration_m_s2 * MANOEUVRE_S
    _choose(
        scene,
        own[0],
        own[1],
        wish[0],
        wish[1],
        base[0],
        base[1],
        speed_max_m_s,
        reach,
        field.deceleration_m_s2,
        field.reaction_s,
        out,
    )
    return float(out[0]), float(out[1])
