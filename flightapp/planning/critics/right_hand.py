"""The right-hand rule between teammates: how far to the right the course must turn (CPPPEA, 2.9, corrected: see below).

The source takes a minimum of angles for a direction and may so turn left. Here each teammate that is not far on the left asks for
a course 45 degrees to the right of its bearing, the largest turn counts, and nothing ever turns left. Head-on both turn right; a
teammate more than 45 degrees on the left gives way itself.
"""

from __future__ import annotations

import math

from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

PASS_RAD = 0.25 * math.pi
SECTOR_RAD = 0.75 * math.pi


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8,f8)")
def right_turn_rad(
    team: Array, n: float, e: float, v_n: float, v_e: float, course_rad: float, rule_m: float, safe_m: float
) -> float:
    """Clockwise turn (>= 0, at most pi) from `course_rad` that the rule asks of a vehicle at (n, e) with velocity (v_n, v_e).

    team: (k, 4) north, east, v_north, v_east. Within `rule_m` of one that comes nearer the rule is on; within `safe_m` if they
    would pass nearer than `rule_m`.
    """
    most = 0.0
    for i in range(team.shape[0]):
        dn = team[i, 0] - n
        de = team[i, 1] - e
        distance = math.hypot(dn, de)
        if distance > safe_m or distance == 0.0:
            continue
        un = team[i, 2] - v_n
        ue = team[i, 3] - v_e
        closing = -(dn * un + de * ue)
        if closing <= 1e-9:
            continue
        if distance > rule_m and abs(dn * ue - de * un) / math.hypot(un, ue) >= rule_m:
            continue
        bearing = math.atan2(de, dn)
        if abs(wrapped_rad(bearing - course_rad)) > SECTOR_RAD:
            continue
        most = max(most, wrapped_rad(bearing + PASS_RAD - course_rad))
    return most
