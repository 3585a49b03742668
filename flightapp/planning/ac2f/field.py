"""The potential field (section 4.2): F_j = eta (p - o_j) / |p - o_j| / gap_j^2 within the influence distance.

Two uses. With the search for a safe velocity, the summed repulsion is capped below the attraction, so that a wall seen as many
small discs deflects and never reverses. The source's own form has no cap, and its speed is limited by what can be braked
before the first disc ahead.
"""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.braking import braking_speed_m_s


@compiled("UniTuple(f8,2)(f8[:,::1],f8,f8,f8,f8,f8)")
def repulsion(scene: Array, n: float, e: float, gain_m2: float, influence_m: float, gap_min_m: float) -> tuple[float, float]:
    """Summed repulsion (north, east) of `scene` (m, 6) at (n, e), relative to an attraction of 1.

    The gap to an inflated edge counts as at least `gap_min_m`.
    """
    north = 0.0
    east = 0.0
    for i in range(scene.shape[0]):
        dn = n - scene[i, 0]
        de = e - scene[i, 1]
        reach = influence_m + scene[i, 2]
        distance2 = dn * dn + de * de
        if distance2 >= reach * reach:
            continue
        distance = math.sqrt(distance2)
        gap = distance - scene[i, 2]
        if gap < influence_m and distance > 1e-9:
            gap = max(gap, gap_min_m)
            force = gain_m2 / (gap * gap) / distance
            north += force * dn
            east += force * de
    return north, east


@compiled("UniTuple(f8,2)(f8[:,::1],f8,f8,f8,f8,f8,f8,f8,f8)")
def deflected(
    scene: Array,
    n: float,
    e: float,
    wish_n: float,
    wish_e: float,
    gain_m2: float,
    influence_m: float,
    repulsion_max: float,
    gap_min_m: float,
) -> tuple[float, float]:
    """The wish (m/s) turned by the repulsion of `scene` (m, 6) at (n, e), capped at `repulsion_max`; its speed stays."""
    speed = math.hypot(wish_n, wish_e)
    if speed < 1e-6:
        return wish_n, wish_e
    push_n, push_e = repulsion(scene, n, e, gain_m2, influence_m, gap_min_m)
    push = math.hypot(push_n, push_e)
    if push > repulsion_max:
        push_n = push_n * repulsion_max / push
        push_e = push_e * repulsion_max / push
    north = wish_n / speed + push_n
    east = wish_e / speed + push_e
    length = math.hypot(north, east)
    if length <= 1e-6:
        return wish_n, wish_e
    return north * speed / length, east * speed / length


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8)")
def speed_limit_ahead_m_s(
    scene: Array, n: float, e: float, ahead_n: float, ahead_e: float, deceleration_m_s2: float, reaction_s: float
) -> float:
    """Highest speed in the direction (ahead_n, ahead_e), a unit vector, that stops before every disc of `scene` (m, 6) there.

    v t + v^2 / (2 a) = gap after a reaction t, faster by what the disc itself moves ahead.
    """
    limit = math.inf
    for i in range(scene.shape[0]):
        dn = scene[i, 0] - n
        de = scene[i, 1] - e
        along = dn * ahead_n + de * ahead_e
        across = dn * ahead_e - de * ahead_n
        inside2 = scene[i, 2] * scene[i, 2] - across * across
        if along <= 0.0 or inside2 <= 0.0:
            continue
        fleeing = scene[i, 3] * ahead_n + scene[i, 4] * ahead_e
        limit = min(limit, fleeing + braking_speed_m_s(along - math.sqrt(inside2), deceleration_m_s2, reaction_s))
    return max(0.0, limit)


@compiled("UniTuple(f8,2)(f8[:,::1],f8,f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def field_velocity(
    scene: Array,
    n: float,
    e: float,
    wish_n: float,
    wish_e: float,
    moving_n: float,
    moving_e: float,
    gain_m2: float,
    influence_m: float,
    deceleration_m_s2: float,
    reaction_s: float,
) -> tuple[float, float]:
    """The source's form: along the resultant of a unit attraction and the repulsion without cap.

    As fast as the wish, where the vehicle can stop before every disc, in that direction and in the one in which it moves.
    """
    speed = math.hypot(wish_n, wish_e)
    if speed < 1e-6:
        return 0.0, 0.0
    push_n, push_e = repulsion(scene, n, e, gain_m2, influence_m, 1e-3)
    north = wish_n / speed + push_n
    east = wish_e / speed + push_e
    length = math.hypot(north, east)
    if length <= 1e-6:
        return 0.0, 0.0
    north /= length
    east /= length
    speed = min(speed, speed_limit_ahead_m_s(scene, n, e, north, east, deceleration_m_s2, reaction_s))
    moving = math.hypot(moving_n, moving_e)
    if moving > 1e-6:
        moving_n /= moving
        moving_e /= moving
        speed = min(speed, speed_limit_ahead_m_s(scene, n, e, moving_n, moving_e, deceleration_m_s2, reaction_s))
    return speed * north, speed * east
