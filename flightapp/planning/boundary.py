"""Crossing the protected boundary, over rows of sides (s, 4: north, east of both ends, m)."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("f8(f8,f8,f8,f8,f8,f8)")
def _side_of(an: float, ae: float, bn: float, be: float, n: float, e: float) -> float:
    return (bn - an) * (e - ae) - (be - ae) * (n - an)


@compiled("b1(f8[:,::1],f8,f8,f8,f8)")
def is_crossed(sides: Array, from_n: float, from_e: float, to_n: float, to_e: float) -> bool:
    """Whether the way (from) -> (to) meets one of `sides`; arriving on it counts, moving along it does not."""
    for i in range(sides.shape[0]):
        an, ae, bn, be = sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3]
        before = _side_of(an, ae, bn, be, from_n, from_e)
        after = _side_of(an, ae, bn, be, to_n, to_e)
        if before == after or before * after > 0.0:
            continue
        if _side_of(from_n, from_e, to_n, to_e, an, ae) * _side_of(from_n, from_e, to_n, to_e, bn, be) <= 0.0:
            return True
    return False
