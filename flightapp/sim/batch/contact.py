"""When two things that move along straight ways in the same time come into reach: continuous in time, no samples."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.planning.boundary import NEVER


@compiled("f8(f8,f8,f8,f8,f8)")
def first_within(an: float, ae: float, bn: float, be: float, reach_m: float) -> float:
    """Where on the relative way (an, ae) -> (bn, be), in [0, 1], the distance to zero is first at most `reach_m`; else NEVER."""
    c = an * an + ae * ae - reach_m * reach_m
    if c <= 0.0:
        return 0.0
    dn, de = bn - an, be - ae
    a = dn * dn + de * de
    b = an * dn + ae * de
    if b >= 0.0 or b * b < a * c:
        return NEVER
    fraction = c / (math.sqrt(b * b - a * c) - b)
    return fraction if fraction <= 1.0 else NEVER
