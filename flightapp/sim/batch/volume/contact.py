"""When two things that move along straight ways in space come into reach of each other; obstacles are upright cylinders.

Everything is per sub-step. Where both ways are level and at one height, these are the planar answers, bit for bit.
"""

from __future__ import annotations

import math

from flightapp.core.clearance import way_gap_m
from flightapp.core.compiled import compiled
from flightapp.planning.boundary import NEVER
from flightapp.sim.batch.contact import first_within


@compiled("f8(f8,f8,f8,f8,f8,f8,f8)")
def first_within_reach(an: float, ae: float, ad: float, bn: float, be: float, bd: float, reach_m: float) -> float:
    """Where on the relative way a -> b, in [0, 1], the distance to zero is first at most `reach_m`; else NEVER."""
    c = an * an + ae * ae + ad * ad - reach_m * reach_m
    if c <= 0.0:
        return 0.0
    dn, de, dd = bn - an, be - ae, bd - ad
    a = dn * dn + de * de + dd * dd
    b = an * dn + ae * de + ad * dd
    if b >= 0.0 or b * b < a * c:
        return NEVER
    fraction = c / (math.sqrt(b * b - a * c) - b)
    return fraction if fraction <= 1.0 else NEVER


@compiled("f8(f8,f8,f8,f8,f8,f8)")
def nearest_m(an: float, ae: float, ad: float, bn: float, be: float, bd: float) -> float:
    """Smallest distance to zero on the relative way a -> b."""
    dn, de, dd = bn - an, be - ae, bd - ad
    length2 = dn * dn + de * de + dd * dd
    share = 0.0 if length2 == 0.0 else min(1.0, max(0.0, -(an * dn + ae * de + ad * dd) / length2))
    return math.hypot(math.hypot(an + share * dn, ae + share * de), ad + share * dd)


@compiled("UniTuple(f8,2)(f8,f8,f8,f8)")
def beside(from_d: float, to_d: float, top_d: float, bottom_d: float) -> tuple[float, float]:
    """The shares of a way from `from_d` to `to_d` (down, m) between which it is below `top_d` and above `bottom_d`.

    (1, 0) where it never is.
    """
    if from_d == to_d:
        return (0.0, 1.0) if top_d < from_d < bottom_d else (1.0, 0.0)
    at_top, at_bottom = (top_d - from_d) / (to_d - from_d), (bottom_d - from_d) / (to_d - from_d)
    begin, end = max(0.0, min(at_top, at_bottom)), min(1.0, max(at_top, at_bottom))
    return (begin, end) if begin < end else (1.0, 0.0)


@compiled("UniTuple(f8,2)(f8,f8,f8,f8,f8,f8,f8,f8,f8)")
def cylinder_contact(
    an: float, ae: float, ad: float, bn: float, be: float, bd: float, reach_m: float, over_m: float, under_m: float
) -> tuple[float, float]:
    """Clearance of a vehicle on the way a -> b, relative to a cylinder of radius `reach_m`, and when it touches it, or NEVER.

    The cylinder reaches from `over_m` to `under_m` (down); it has the vehicle's body in it, as high as it is wide. Beside it the
    clearance is the planar one. Above and below it is the distance to its edge or face, from the nearest places of the planar
    and of the vertical way, which may be passed at different times: never more than the true one.
    """
    begin, end = beside(ad, bd, over_m, under_m)
    if begin < end:
        dn, de = bn - an, be - ae
        from_n, from_e, to_n, to_e = an + begin * dn, ae + begin * de, an + end * dn, ae + end * de
        gap = way_gap_m(from_n, from_e, to_n - from_n, to_e - from_e, reach_m)
        touched = NEVER
        if gap <= 0.0:
            touched = begin + (end - begin) * first_within(from_n, from_e, to_n, to_e, reach_m)
        return gap, touched
    planar = max(0.0, way_gap_m(an, ae, bn - an, be - ae, reach_m))
    vertical = max(0.0, max(over_m - max(ad, bd), min(ad, bd) - under_m))
    return math.hypot(planar, vertical), NEVER
