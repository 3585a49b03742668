"""Crossing the protected boundary, over rows of sides (s, 4: north, east of both ends, m)."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array

NEVER = 2.0
"""Later than the end of a way, which is at 1."""


@compiled("f8(f8,f8,f8,f8,f8,f8)")
def _side_of(an: float, ae: float, bn: float, be: float, n: float, e: float) -> float:
    return (bn - an) * (e - ae) - (be - ae) * (n - an)


@compiled("f8(f8,f8,f8,f8,f8,f8,f8,f8)")
def crossing(pn: float, pe: float, qn: float, qe: float, an: float, ae: float, bn: float, be: float) -> float:
    """Where on the way p -> q, in [0, 1], it meets the side a -> b; NEVER if not, nor while it moves along it."""
    before = _side_of(an, ae, bn, be, pn, pe)
    after = _side_of(an, ae, bn, be, qn, qe)
    if before == after or before * after > 0.0:
        return NEVER
    meets = _side_of(pn, pe, qn, qe, an, ae) * _side_of(pn, pe, qn, qe, bn, be) <= 0.0
    return before / (before - after) if meets else NEVER


@compiled("b1(f8[:,::1],f8,f8,f8,f8)")
def is_crossed(sides: Array, from_n: float, from_e: float, to_n: float, to_e: float) -> bool:
    """Whether the way (from) -> (to) meets one of `sides`; arriving on it counts, moving along it does not."""
    for i in range(sides.shape[0]):
        if crossing(from_n, from_e, to_n, to_e, sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3]) != NEVER:
            return True
    return False
