"""The command for a vehicle that only flies along its nose: it turns first where turning would lead out of the safety cell.

Such a vehicle turns towards the commanded course as far as it can in one period and flies the commanded speed times the cosine
of what is left to turn.
"""

from __future__ import annotations

import math

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array, Limits
from flightapp.planning.encirclement.situation import Situation
from flightapp.planning.plane import Point

STANDING_M_S = 1e-6
ACROSS = 1e-3
"""Less than this cosine of what is left to turn: on the spot."""


def nose_first(situation: Situation, velocity: Point, limits: Limits, deceleration_m_s2: float) -> tuple[Point, float]:
    """The command nearest to `velocity` (m/s) whose arc over one period stays in the safety cell, and the yaw (rad).

    Along every heading of the turn the way to the cell's border is enough for this period and for stopping after it.
    """
    wanted = math.hypot(*velocity)
    if wanted < STANDING_M_S:
        return (0.0, 0.0), situation.yaw_rad
    course = math.atan2(velocity[1], velocity[0])
    error = wrap_pi(course - situation.yaw_rad)
    most = limits.yaw_rate_max_rad_s * situation.period_s
    turn = max(-most, min(most, error))
    left = math.cos(error - turn)
    if left < ACROSS:
        return (0.0, 0.0), course
    bulge_m = wanted * situation.period_s * abs(turn) / 8.0
    planes = situation.planes[: situation.plane_count]
    way_m = min(_way_m(planes, situation.yaw_rad + share * turn, bulge_m) for share in (0.0, 0.5, 1.0))
    speed = min(wanted * left, way_m / situation.period_s, math.sqrt(2.0 * deceleration_m_s2 * way_m))
    commanded = min(speed / left, limits.speed_max_m_s)
    return (commanded * math.cos(course), commanded * math.sin(course)), course


def _way_m(planes: Array, heading_rad: float, spare_m: float) -> float:
    """How far a way along `heading_rad` stays within all planes, `spare_m` before each."""
    way = math.inf
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    for n, e, room in planes.tolist():
        towards = n * cos + e * sin
        if towards > 0.0:
            way = min(way, max(0.0, room - spare_m) / towards)
    return way
