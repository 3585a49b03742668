"""The sum of all forces on a vehicle at one moment, and what the rest of a decision needs to know of it."""

from __future__ import annotations

import math

import numba
from numpy.typing import NDArray

from flightapp.core.compiled import compiled, inlined
from flightapp.core.types import Array
from flightapp.planning.adaptive_apf.forces import (
    VECTOR,
    Vector,
    activation_m,
    attraction,
    closest_approach,
    demand,
    repulsion,
)
from flightapp.planning.adaptive_apf.fuzzy import speed_gain
from flightapp.planning.adaptive_apf.gains import GAINS, Gains
from flightapp.space.bodies import BODIES, EAST, INDICES, LENGTH, NORTH, NUMBER, ROW, V_DOWN, V_EAST, V_NORTH, WHOLE

KNOWN, REACH, UNTIL, SIDE_N, SIDE_E, SIDE_D, FIRST_N, FIRST_E, FIRST_D = range(9)
TRACK_COLUMNS = 9
"""What is remembered of one body: whether anything is, its activation distance (m), until when (s) the side of passing is kept,
that side, and the line of sight when the manoeuvre began."""

FORCE, PUSH, RISK, NEAREST, COURSE, GAIN, REACH_OUT = 0, 3, 6, 7, 8, 9, 10
FIELD_SIZE = 11
"""Of the result: force (3), summed repulsion (3), largest demand, least gap (m), 1 on a collision course, signed share by which
the speed changes, and the activation distance (m) of the nearest body."""

SHRINKING_M_S = 2.0
SMOOTHING_S = 0.3
KEPT_S = 0.5
"""A side is kept until there was no collision course for this long."""
HEAD_ON_M = 0.05
SLOW_M_S = 0.1
BRAKES_WITHIN_RAD = 0.25 * math.pi
FAR_M, NEAR_M = 3.0, 1.0
"""Where the zones of the source's return force meet; it has no values for them, nor for the rest of these."""
FAR_1_S2, ARRIVING, NEAR_1_M_S2, NEAR_POWER, NEAR_SHARE = 0.5, -0.5, 0.5, 1.0, 0.9


@compiled(VECTOR(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def passing_side(mn: float, me: float, md: float, miss: float, wn: float, we: float, vertical: float) -> Vector:
    """Unit vector that makes the miss (mn, me, md) at relative velocity (wn, we) larger; head-on all pass on the same hand."""
    if miss >= HEAD_ON_M:
        n, e, d = -mn / miss, -me / miss, -vertical * md / miss
        size = math.sqrt(n * n + e * e + d * d)
        if size > 1e-6:
            return n / size, e / size, d / size
    level = math.sqrt(wn * wn + we * we)
    if level < 1e-6:
        return 1.0, 0.0, 0.0
    return -we / level, wn / level, 0.0


@inlined
def _steer(track, k, r, w, approach, demanded, t_s, gains):  # type: ignore[no-untyped-def]
    """Steering force (2.6) past body `k` on a collision course; remembers the side and how the line of sight turned."""
    side_n, side_e, side_d = passing_side(approach[1], approach[2], approach[3], approach[4], w[0], w[1], gains.vertical_weight)
    if t_s <= track[k, UNTIL]:
        if side_n * track[k, SIDE_N] + side_e * track[k, SIDE_E] + side_d * track[k, SIDE_D] < 0.0:
            side_n, side_e, side_d = track[k, SIDE_N], track[k, SIDE_E], track[k, SIDE_D]
    else:
        track[k, FIRST_N], track[k, FIRST_E], track[k, FIRST_D] = r
    track[k, SIDE_N], track[k, SIDE_E], track[k, SIDE_D] = side_n, side_e, side_d
    track[k, UNTIL] = t_s + KEPT_S
    first = math.sqrt(track[k, FIRST_N] ** 2 + track[k, FIRST_E] ** 2 + track[k, FIRST_D] ** 2)
    now = math.sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
    turned = 1.0
    if first > 1e-9 and now > 1e-9:
        turned = (r[0] * track[k, FIRST_N] + r[1] * track[k, FIRST_E] + r[2] * track[k, FIRST_D]) / (first * now)
    size = gains.steering_m_s2 * min(1.0, demanded) * 0.5 * (1.0 + turned)
    return size * side_n, size * side_e, size * side_d


@compiled(NUMBER(*(NUMBER,) * 5, GAINS))
def braking_m_s2(closing_m_s: float, gap_m: float, speed_m_s: float, ahead: float, authority: float, gains: Gains) -> float:
    """Deceleration that just stops before a body, where it lies within 45 degrees of the course (2.6); ahead: cosine of that."""
    if speed_m_s < SLOW_M_S or closing_m_s <= 0.0:
        return 0.0
    angle = math.acos(min(1.0, max(-1.0, ahead)))
    if angle >= BRAKES_WITHIN_RAD:
        return 0.0
    room = max(gap_m - gains.reach_min_m, gains.gap_min_m)
    taper = math.cos(2.0 * angle)
    return authority * min(gains.braking_m_s2, closing_m_s * closing_m_s / (2.0 * room)) * taper * taper


@compiled(VECTOR(*(NUMBER,) * 3, ROW))
def return_by_zones(n: float, e: float, d: float, velocity: Array) -> Vector:
    """The source's return force (equation 21) for a line (n, e, d) m away, repaired as its specification says (2.6).

    A pull far from the line, braking on the way to it, a weak pull near it. It jumps where the zones meet.
    """
    away = math.sqrt(n * n + e * e + d * d)
    if away < 1e-9:
        return 0.0, 0.0, 0.0
    if away >= FAR_M:
        gain = FAR_1_S2
    elif away > NEAR_M:
        nearing = (velocity[0] * n + velocity[1] * e + velocity[2] * d) / away
        gain = ARRIVING * nearing * nearing / (away - NEAR_SHARE * NEAR_M) / away if nearing > 0.0 else 0.0
    else:
        gain = NEAR_1_M_S2 * away**NEAR_POWER
    return gain * n, gain * e, gain * d


@compiled(VECTOR(ROW, ROW, ROW, ROW, GAINS))
def return_force(place: Array, velocity: Array, start: Array, goal: Array, gains: Gains) -> Vector:
    """Back to the line from `start` to `goal` (3,), damped and limited (2.6)."""
    ln, le, ld = goal[0] - start[0], goal[1] - start[1], goal[2] - start[2]
    length = math.sqrt(ln * ln + le * le + ld * ld)
    if gains.return_1_s2 == 0.0 or length < 1e-9:
        return 0.0, 0.0, 0.0
    ln, le, ld = ln / length, le / length, ld / length
    n, e, d = goal[0] - place[0], goal[1] - place[1], goal[2] - place[2]
    along = n * ln + e * le + d * ld
    drift = velocity[0] * ln + velocity[1] * le + velocity[2] * ld
    if gains.return_zones != 0.0:
        return return_by_zones(n - along * ln, e - along * le, d - along * ld, velocity)
    damping = 2.0 * math.sqrt(gains.return_1_s2)
    n = gains.return_1_s2 * (n - along * ln) - damping * (velocity[0] - drift * ln)
    e = gains.return_1_s2 * (e - along * le) - damping * (velocity[1] - drift * le)
    d = gains.return_1_s2 * (d - along * ld) - damping * (velocity[2] - drift * ld)
    size = math.sqrt(n * n + e * e + d * d)
    share = gains.return_max_m_s2 / size if size > gains.return_max_m_s2 else 1.0
    return share * n, share * e, share * d


@compiled(NUMBER(ROW, NUMBER, NUMBER))
def remembered_reach_m(track: Array, wanted_m: float, dt_s: float) -> float:
    """The activation distance after low-pass and limited shrinking, kept in `track` (TRACK_COLUMNS,)."""
    if track[KNOWN] == 0.0 or dt_s <= 0.0:
        if track[KNOWN] == 0.0:
            track[KNOWN], track[REACH] = 1.0, wanted_m
        return float(track[REACH])
    change = (wanted_m - track[REACH]) * dt_s / (dt_s + SMOOTHING_S)
    track[REACH] += max(change, -SHRINKING_M_S * dt_s)
    return float(track[REACH])


@compiled(numba.void(BODIES, INDICES, BODIES, WHOLE, ROW, ROW, ROW, ROW, BODIES, GAINS, NUMBER, NUMBER, ROW))
def sum_forces(
    bodies: Array,
    which: NDArray,  # type: ignore[type-arg]
    gaps: Array,
    count: int,
    place: Array,
    velocity: Array,
    start: Array,
    goal: Array,
    tracks: Array,
    gains: Gains,
    t_s: float,
    dt_s: float,
    out: Array,
) -> None:
    """Fill `out` (FIELD_SIZE,) for a vehicle at `place` with `velocity` on its way from `start` to `goal`, all (3,).

    The first `count` of `which` are rows of `bodies`, and of `gaps` (k, 4) what `nearest_bodies` says of them: distances from
    the vehicle's centre. tracks (n, TRACK_COLUMNS) is kept from step to step. Escape (module B) is added by the caller.
    """
    goal_n, goal_e, goal_d = goal[0] - place[0], goal[1] - place[1], goal[2] - place[2]
    n, e, d = attraction(goal_n, goal_e, goal_d, gains)
    push_n = push_e = push_d = 0.0
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    risk = 0.0
    on_course = 0.0
    share = 0.0
    least = math.inf
    least_reach = 0.0
    steer_n = steer_e = steer_d = 0.0
    brake = 0.0
    for j in range(count):
        k = which[j]
        gap = gaps[j, 0] - gains.body_radius_m
        wn, we, wd = velocity[0] - bodies[k, V_NORTH], velocity[1] - bodies[k, V_EAST], velocity[2] - bodies[k, V_DOWN]
        closing = -(wn * gaps[j, 1] + we * gaps[j, 2] + wd * gaps[j, 3])
        body_speed = math.sqrt(bodies[k, V_NORTH] ** 2 + bodies[k, V_EAST] ** 2 + bodies[k, V_DOWN] ** 2)
        wanted = activation_m(closing, body_speed, bodies[k, LENGTH], gains)
        reach = remembered_reach_m(tracks[k], wanted, dt_s)
        if gap < least:
            least, least_reach = gap, reach
            if gains.adaptive != 0.0 and gap < reach:
                angle = 90.0
                if body_speed > SLOW_M_S and speed > SLOW_M_S:
                    cosine = velocity[0] * bodies[k, V_NORTH] + velocity[1] * bodies[k, V_EAST] + velocity[2] * bodies[k, V_DOWN]
                    angle = math.degrees(math.acos(min(1.0, max(-1.0, cosine / (speed * body_speed)))))
                share = speed_gain(reach, angle, gains.printed)
                if gains.printed == 0.0:
                    share = -share if closing > 0.0 else share
        if gains.only_closing == 0.0 or closing > 0.0:
            fn, fe, fd = repulsion(gap, gaps[j, 1], gaps[j, 2], gaps[j, 3], goal_n, goal_e, goal_d, reach, gains)
            push_n, push_e, push_d = push_n + fn, push_e + fe, push_d + fd
        if gains.predictive == 0.0 or closing <= 0.0:
            continue
        radius = bodies[k, LENGTH]
        if gaps[j, 3] == 0.0:  # beside it: past its axis, however high it is
            rn, re, rd, wd = bodies[k, NORTH] - place[0], bodies[k, EAST] - place[1], 0.0, 0.0
        else:
            depth = gaps[j, 0] + radius
            rn, re, rd = -depth * gaps[j, 1], -depth * gaps[j, 2], -depth * gaps[j, 3]
        approach = closest_approach(rn, re, rd, wn, we, wd)
        need = radius + gains.body_radius_m + gains.margin_m - approach[4]
        if approach[0] <= 0.0 or approach[0] > gains.horizon_s or need <= 0.0:
            continue
        on_course = 1.0
        demanded = demand(need, approach[0], gains)
        risk = max(risk, min(1.0, demanded))
        sn, se, sd = _steer(tracks, k, (rn, re, rd), (wn, we, wd), approach, demanded, t_s, gains)
        steer_n, steer_e, steer_d = steer_n + sn, steer_e + se, steer_d + sd
        distance = math.sqrt(rn * rn + re * re + rd * rd)
        if speed > SLOW_M_S and distance > 1e-9:
            ahead = (velocity[0] * rn + velocity[1] * re + velocity[2] * rd) / (speed * distance)
            brake = max(brake, braking_m_s2(closing, gap, speed, ahead, 1.0, gains))
    out[PUSH], out[PUSH + 1], out[PUSH + 2] = push_n, push_e, push_d
    n, e, d = n + push_n + steer_n, e + push_e + steer_e, d + push_d + steer_d
    if gains.predictive != 0.0:
        back_n, back_e, back_d = return_force(place, velocity, start, goal, gains)
        calm = 1.0 - risk
        n, e, d = n + calm * back_n, e + calm * back_e, d + calm * back_d
        if brake > 0.0:
            n, e, d = (
                n - brake * velocity[0] / speed,
                e - brake * velocity[1] / speed,
                d - brake * velocity[2] / speed,
            )
    out[FORCE], out[FORCE + 1], out[FORCE + 2] = n, e, d
    out[RISK], out[NEAREST], out[COURSE], out[GAIN], out[REACH_OUT] = risk, least, on_course, share, least_reach
