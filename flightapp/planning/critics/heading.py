"""Heading: how well the end of a candidate points at the aim."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.elementary import angle


@compiled("void(f8[::1],f8[::1],f8[::1],f8[::1],f8,f8,f8[::1])")
def heading_score(north: Array, east: Array, cosines: Array, sines: Array, aim_n: float, aim_e: float, out: Array) -> None:
    """Fill out (n,): pi - |angle between the end heading and the line of sight to the aim| (rad).

    north, east (n,): where each candidate ends, m; cosines, sines (n,): its heading there.
    """
    for c in range(out.shape[0]):
        sight_n = aim_n - north[c]
        sight_e = aim_e - east[c]
        at_aim = (sight_n == 0.0) & (sight_e == 0.0)
        sight_n = 1.0 if at_aim else sight_n
        along = cosines[c] * sight_n + sines[c] * sight_e
        across = cosines[c] * sight_e - sines[c] * sight_n
        out[c] = math.pi - angle(abs(across), along)
