"""Where a moving disc is: constant speed, turning round at the edges of the area; a pure function of time."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("UniTuple(f8,2)(f8,f8,f8,f8,f8)")
def _to_and_fro(start: float, speed: float, low: float, high: float, t_s: float) -> tuple[float, float]:
    """Position and velocity at `t_s` on the way between `low` and `high`."""
    length = high - low
    if speed == 0.0 or length <= 0.0:
        return start, 0.0
    way = (start - low + speed * t_s) % (2.0 * length)
    if way <= length:
        return low + way, speed
    return low + 2.0 * length - way, -speed


@compiled("UniTuple(f8,4)(f8[:,::1],i8,f8[::1],f8)")
def disc_at(discs: Array, k: int, area: Array, t_s: float) -> tuple[float, float, float, float]:
    """North, east (m), v_north, v_east (m/s) of disc `k` at `t_s`; area (4,): north and east, least and greatest."""
    n, vn = _to_and_fro(discs[k, 0], discs[k, 3], area[0], area[1], t_s)
    e, ve = _to_and_fro(discs[k, 1], discs[k, 4], area[2], area[3], t_s)
    return n, e, vn, ve


@compiled("UniTuple(f8,4)(f8[:,::1],i8,b1,f8[::1],f8,f8)")
def disc_way(discs: Array, k: int, moves: bool, area: Array, from_s: float, to_s: float) -> tuple[float, float, float, float]:
    """North and east of disc `k` at `from_s` and at `to_s`; where it `moves` not, it is where its row says."""
    if not moves:
        return discs[k, 0], discs[k, 1], discs[k, 0], discs[k, 1]
    from_n, from_e, _, _ = disc_at(discs, k, area, from_s)
    to_n, to_e, _, _ = disc_at(discs, k, area, to_s)
    return from_n, from_e, to_n, to_e
