"""The single forces: attraction, repulsion with its goal factor, closest approach, and when a body begins to repel."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.planning.adaptive_apf.gains import GAINS, Gains
from flightapp.space.bodies import NUMBER

VECTOR = numba.types.UniTuple(NUMBER, 3)  # type: ignore[no-untyped-call]
PAIR = numba.types.UniTuple(NUMBER, 2)  # type: ignore[no-untyped-call]
APPROACH = numba.types.UniTuple(NUMBER, 5)  # type: ignore[no-untyped-call]
Vector = tuple[float, float, float]
STANDING_M_S = 1e-6
DELAY_LEFT_S = 0.2
"""A manoeuvre has at least this long."""
GROWING_REACH_M = 0.5
RADIUS_SHARE, RADIUS_SHARE_PRINTED = 0.25, 1.5


@compiled(VECTOR(NUMBER, NUMBER, NUMBER, GAINS))
def attraction(n: float, e: float, d: float, gains: Gains) -> Vector:
    """Towards a goal (n, e, d) m away: proportional up to the attraction's reach, from there on constant (2.1)."""
    distance = math.sqrt(n * n + e * e + d * d)
    gain = gains.attraction_1_s2 * (gains.attraction_reach_m / distance if distance > gains.attraction_reach_m else 1.0)
    return gain * n, gain * e, gain * d


@compiled(PAIR(NUMBER, NUMBER, GAINS))
def goal_factor(distance_m: float, reach_m: float, gains: Gains) -> tuple[float, float]:
    """s, by which the distance to the goal scales a body's potential, and s' over that distance, finite at the goal (2.3)."""
    if gains.goal_aware == 0.0:
        return 1.0, 0.0
    power = gains.goal_power
    near = distance_m**power
    slope = power * distance_m ** (power - 2.0)
    if gains.goal_bounded == 0.0:
        return near, slope
    far = max(2.0 * reach_m, gains.goal_scale_min_m) ** power
    return near / (near + far), slope * far / ((near + far) * (near + far))


@compiled(NUMBER(NUMBER, NUMBER, NUMBER, GAINS))
def repulsive_potential(gap_m: float, distance_m: float, reach_m: float, gains: Gains) -> float:
    """Of a body `gap_m` from the vehicle's surface, `distance_m` from the goal; `repulsion` is its negative gradient."""
    if gap_m >= reach_m:
        return 0.0
    excess = 1.0 / max(gap_m, gains.gap_min_m) - 1.0 / reach_m
    return 0.5 * gains.repulsion * excess * excess * goal_factor(distance_m, reach_m, gains)[0]


@compiled(VECTOR(*(NUMBER,) * 8, GAINS))
def repulsion(
    gap_m: float,
    away_n: float,
    away_e: float,
    away_d: float,
    goal_n: float,
    goal_e: float,
    goal_d: float,
    reach_m: float,
    gains: Gains,
) -> Vector:
    """Of a body whose distance grows along the unit vector `away`, the goal (goal_n, goal_e, goal_d) m away (2.2, 2.3).

    Away from the body, and, with module A, towards the goal. Continuous, zero from the reach on, limited.
    """
    if gap_m >= reach_m:
        return 0.0, 0.0, 0.0
    gap = max(gap_m, gains.gap_min_m)
    excess = 1.0 / gap - 1.0 / reach_m
    scale, slope = goal_factor(math.sqrt(goal_n * goal_n + goal_e * goal_e + goal_d * goal_d), reach_m, gains)
    out = gains.repulsion * excess / (gap * gap) * scale
    inwards = 0.5 * gains.repulsion * excess * excess * slope
    n, e, d = out * away_n + inwards * goal_n, out * away_e + inwards * goal_e, out * away_d + inwards * goal_d
    size = math.sqrt(n * n + e * e + d * d)
    share = gains.force_max_m_s2 / size if size > gains.force_max_m_s2 else 1.0
    return share * n, share * e, share * d


@compiled(APPROACH(*(NUMBER,) * 6))
def closest_approach(
    rn: float, re: float, rd: float, wn: float, we: float, wd: float
) -> tuple[float, float, float, float, float]:
    """(s until the closest approach, miss vector, its length) to a centre at `r`, flown at by the relative velocity `w` (2.5)."""
    speed2 = wn * wn + we * we + wd * wd
    t_s = max(0.0, (rn * wn + re * we + rd * wd) / speed2) if speed2 > STANDING_M_S * STANDING_M_S else 0.0
    n, e, d = rn - wn * t_s, re - we * t_s, rd - wd * t_s
    return t_s, n, e, d, math.sqrt(n * n + e * e + d * d)


@compiled(NUMBER(NUMBER, NUMBER, GAINS))
def demand(need_m: float, t_s: float, gains: Gains) -> float:
    """What share of the vehicle's ability a detour of `need_m` within `t_s` takes; more than 1 where it is too late."""
    if gains.kinematic != 0.0:
        return need_m / (gains.speed_m_s * max(t_s, 1e-9))
    left = max(t_s - gains.delay_s, DELAY_LEFT_S)
    return 2.0 * need_m / (left * left) / gains.steering_m_s2


@compiled(NUMBER(NUMBER, NUMBER, NUMBER, GAINS))
def activation_m(closing_m_s: float, body_speed_m_s: float, radius_m: float, gains: Gains) -> float:
    """Gap below which a body repels (2.7): reaction and stopping distance, or as printed, measured from the surface."""
    if gains.adaptive == 0.0:
        return gains.reach_m
    if gains.printed != 0.0:
        return min(gains.reach_max_m, gains.reach_min_m + gains.obstacle_s * body_speed_m_s + RADIUS_SHARE_PRINTED * radius_m)
    closing = max(0.0, closing_m_s)
    wanted = (
        gains.reach_min_m + gains.delay_s * closing + closing * closing / (2.0 * gains.braking_m_s2) + RADIUS_SHARE * radius_m
    )
    return min(gains.reach_max_m, max(gains.reach_min_m + GROWING_REACH_M, wanted))
