"""When two things that move along straight ways in the same time come near: continuous in time, no samples."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled

NEVER = 2.0
"""Later than the end of the way, which is at 1."""


@compiled("f8(f8,f8,f8,f8)")
def closest_m(an: float, ae: float, bn: float, be: float) -> float:
    """Smallest distance to zero on the relative way (an, ae) -> (bn, be)."""
    dn, de = bn - an, be - ae
    length2 = dn * dn + de * de
    fraction = 0.0
    if length2 > 0.0:
        fraction = min(1.0, max(0.0, -(an * dn + ae * de) / length2))
    return math.hypot(an + fraction * dn, ae + fraction * de)


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


@compiled("f8(f8,f8,f8,f8,f8,f8,f8,f8)")
def crossing(pn: float, pe: float, qn: float, qe: float, an: float, ae: float, bn: float, be: float) -> float:
    """Where on the way p -> q, in [0, 1], it meets the side a -> b; NEVER if not. As flightapp.planning.plane.crosses."""
    before = (bn - an) * (pe - ae) - (be - ae) * (pn - an)
    after = (bn - an) * (qe - ae) - (be - ae) * (qn - an)
    if before == after or before * after > 0.0:
        return NEVER
    side_a = (qn - pn) * (ae - pe) - (qe - pe) * (an - pn)
    side_b = (qn - pn) * (be - pe) - (qe - pe) * (bn - pn)
    return before / (before - after) if side_a * side_b <= 0.0 else NEVER
