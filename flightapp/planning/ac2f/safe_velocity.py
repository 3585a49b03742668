"""The velocity next to the wanted one from which the vehicle can still stop before every disc (section 4.2).

Stopping is judged relative to the disc's own motion, with a reaction time, and also for what is reached of a velocity after a
short change towards it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.ac2f.records import NUMBER, ROWS, WHOLE

DIRECTIONS = 36
SPEEDS = 6
STEPS = tuple((math.cos(k * 2.0 * math.pi / DIRECTIONS), math.sin(k * 2.0 * math.pi / DIRECTIONS)) for k in range(DIRECTIONS))
TURNS = np.array(STEPS)
SAFE_SPEED = 6  # column after the scene's own
ROUNDING = 1e-9  # what the pruning allows for rounding


class Braking(NamedTuple):
    """What stopping may assume, and the costs between which the choice is made; all floats."""

    deceleration_m_s2: float
    reaction_s: float
    manoeuvre_s: float = 0.2
    """A velocity is judged by what this long a change reaches of it, too."""
    leaving_gain_per_s: float = 2.0
    """Speed out of an inflated disc, per metre of depth."""
    leaving_speed_max_m_s: float = 1.0
    excess_cost: float = 8.0
    """Cost of 1 m/s too fast to stop; a deviation along the wish costs 1."""
    reached_excess_cost: float = 8.0
    """The same of what is reached within the manoeuvre: high, and it is never given up for the wish."""
    across_cost: float = 0.3
    """Cost of 1 m/s across the wish."""
    change_cost: float = 0.1
    """Cost of 1 m/s of change from the present velocity."""


BRAKING_TYPE = numba.types.NamedUniTuple(numba.float64, len(Braking._fields), Braking)  # type: ignore[no-untyped-call]
PAIR_TYPE = numba.types.UniTuple(NUMBER, 2)  # type: ignore[no-untyped-call]


@compiled(NUMBER(ROWS, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, BRAKING_TYPE, NUMBER))
def _excess_m_s(
    relevant: Array, count: int, n: float, e: float, vn: float, ve: float, braking: Braking, enough_m_s: float
) -> float:
    """By how much (vn, ve) is too fast towards the worst disc on its way, or too slow out of one; 0 where it is safe.

    relevant: (>= count, 7) as `_sort_relevant` fills it. Above `enough_m_s` the result is no more than a lower bound.
    """
    excess = 0.0
    speed = math.sqrt(vn * vn + ve * ve)
    for i in range(count):
        if excess > enough_m_s or speed - relevant[i, SAFE_SPEED] <= excess:
            break
        dn = relevant[i, 0] - n
        de = relevant[i, 1] - e
        un = vn - relevant[i, 3]
        ue = ve - relevant[i, 4]
        closing = un * dn + ue * de
        if relevant[i, 5] > 0.0:
            outwards = -closing / max(1e-9, math.sqrt(dn * dn + de * de))
            excess = max(excess, min(braking.leaving_speed_max_m_s, braking.leaving_gain_per_s * relevant[i, 5]) - outwards)
        if closing <= 0.0:
            continue
        across = un * de - ue * dn
        speed2 = un * un + ue * ue
        radius2 = relevant[i, 2] * relevant[i, 2]
        if across * across >= radius2 * speed2:
            continue
        relative = math.sqrt(speed2)
        gap = closing / relative - math.sqrt(radius2 - across * across / speed2)
        excess = max(excess, relative - braking_speed_m_s(gap, braking.deceleration_m_s2, braking.reaction_s))
    return excess


@compiled(NUMBER(ROWS, WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, BRAKING_TYPE, NUMBER))
def _risk_cost(
    relevant: Array,
    count: int,
    n: float,
    e: float,
    vn: float,
    ve: float,
    base_n: float,
    base_e: float,
    braking: Braking,
    enough: float,
) -> float:
    """What it costs that (vn, ve), and what is reached of it from the base velocity, are too fast to stop; 0: both are safe.

    Above `enough` the result is no more than a lower bound.
    """
    change = math.sqrt((vn - base_n) ** 2 + (ve - base_e) ** 2)
    reach = braking.deceleration_m_s2 * braking.manoeuvre_s
    if change <= reach:
        gain = max(braking.excess_cost, braking.reached_excess_cost)
        return gain * _excess_m_s(relevant, count, n, e, vn, ve, braking, enough / gain)
    gain = braking.reached_excess_cost
    first_n = base_n + reach / change * (vn - base_n)
    first_e = base_e + reach / change * (ve - base_e)
    cost = gain * _excess_m_s(relevant, count, n, e, first_n, first_e, braking, enough / gain)
    if cost > enough:
        return cost
    gain = braking.excess_cost
    return cost + gain * _excess_m_s(relevant, count, n, e, vn, ve, braking, (enough - cost) / gain)


@compiled(WHOLE(ROWS, NUMBER, NUMBER, NUMBER, BRAKING_TYPE, ROWS))
def _sort_relevant(scene: Array, n: float, e: float, speed_m_s: float, braking: Braking, out: Array) -> int:
    """Copy the discs before which a vehicle with `speed_m_s` may not be able to stop, or in which it is; returns how many.

    out (m, 7): the scene's columns and a speed that is safe whatever its direction, in ascending order.
    """
    count = 0
    for i in range(scene.shape[0]):
        dn = scene[i, 0] - n
        de = scene[i, 1] - e
        distance2 = dn * dn + de * de
        drift = abs(scene[i, 3]) + abs(scene[i, 4])
        relative = speed_m_s + drift
        reach = scene[i, 2] + relative * (braking.reaction_s + 0.5 * relative / braking.deceleration_m_s2) + ROUNDING
        safe = -math.inf
        if scene[i, 5] <= 0.0:
            if distance2 > reach * reach:
                continue
            gap = math.sqrt(distance2) - scene[i, 2]
            safe = braking_speed_m_s(gap, braking.deceleration_m_s2, braking.reaction_s) - drift - ROUNDING
        place = count
        while place > 0 and out[place - 1, SAFE_SPEED] > safe:
            for column in range(SAFE_SPEED + 1):
                out[place, column] = out[place - 1, column]
            place -= 1
        for column in range(SAFE_SPEED):
            out[place, column] = scene[i, column]
        out[place, SAFE_SPEED] = safe
        count += 1
    return count


@compiled(PAIR_TYPE(ROWS, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, BRAKING_TYPE))
def safe_velocity(
    scene: Array,
    n: float,
    e: float,
    wish_n: float,
    wish_e: float,
    base_n: float,
    base_e: float,
    speed_max: float,
    braking: Braking,
) -> tuple[float, float]:
    """The velocity (m/s) nearest to the wish from which a vehicle at (n, e) can stop before every disc of `scene` (m, 6).

    base: the present velocity, m/s; it breaks ties against chatter. Where nothing is safe, the least excess wins.
    """
    fastest = max(math.hypot(wish_n, wish_e), speed_max, math.hypot(base_n, base_e))
    relevant = np.empty((scene.shape[0], SAFE_SPEED + 1))
    count = _sort_relevant(scene, n, e, fastest, braking, relevant)
    risk = _risk_cost(relevant, count, n, e, wish_n, wish_e, base_n, base_e, braking, math.inf)
    if risk == 0.0:
        return wish_n, wish_e
    wish = math.hypot(wish_n, wish_e)
    unit_n = wish_n / wish if wish > 1e-9 else 1.0
    unit_e = wish_e / wish if wish > 1e-9 else 0.0
    best = risk + braking.change_cost * math.hypot(wish_n - base_n, wish_e - base_e)
    first = -1  # place of the best in the order of directions, for equal costs
    best_n = wish_n
    best_e = wish_e
    for outwards in range(DIRECTIONS):
        k = (outwards + 1) // 2 if outwards % 2 == 1 else (DIRECTIONS - outwards // 2) % DIRECTIONS
        cos = unit_n * TURNS[k, 0] - unit_e * TURNS[k, 1]
        sin = unit_e * TURNS[k, 0] + unit_n * TURNS[k, 1]
        for j in range(SPEEDS):
            speed = wish * 0.5 * (j + 1) if j < 2 else speed_max * 0.25 * (j - 1)
            if k == 0 and j == 1:
                speed = 0.0
            cost = abs(wish - speed * TURNS[k, 0]) + braking.across_cost * speed * abs(TURNS[k, 1])
            if cost > best:
                continue
            vn = speed * cos
            ve = speed * sin
            cost += braking.change_cost * math.sqrt((vn - base_n) ** 2 + (ve - base_e) ** 2)
            if cost > best:
                continue
            too_much = (best - cost) * (1.0 + 1e-9)
            cost += _risk_cost(relevant, count, n, e, vn, ve, base_n, base_e, braking, too_much)
            place = SPEEDS * k + j
            if cost < best or (cost == best and place < first):
                best = cost
                first = place
                best_n = vn
                best_e = ve
    return best_n, best_e
