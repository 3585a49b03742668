"""Flying only where the camera has looked: speed limit into unseen sectors, and where to point the nose."""

from __future__ import annotations

import math

from flightapp.core.angles import TWO_PI
from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("b1(f8,f8[:,::1])")
def leads_into_unseen(bearing_rad: float, unseen: Array) -> bool:
    """Whether `bearing_rad` lies in one of the intervals `unseen` (k, 2: from, to, clockwise, rad)."""
    for i in range(unseen.shape[0]):
        width = (unseen[i, 1] - unseen[i, 0]) % TWO_PI
        if width == 0.0 and unseen[i, 1] != unseen[i, 0]:
            width = TWO_PI
        if (bearing_rad - unseen[i, 0]) % TWO_PI < width:
            return True
    return False


@compiled("f8(f8,f8,f8[:,::1],f8)")
def seen_share(n_m_s: float, e_m_s: float, unseen: Array, speed_max_m_s: float) -> float:
    """The share of a velocity (m/s) that may be flown: 1, or what leaves `speed_max_m_s` where it leads into an unseen sector."""
    speed = math.hypot(n_m_s, e_m_s)
    if unseen.shape[0] == 0 or speed <= speed_max_m_s or not leads_into_unseen(math.atan2(e_m_s, n_m_s), unseen):
        return 1.0
    return speed_max_m_s / speed


@compiled("f8(f8,f8,f8,f8,f8,b1,f8,f8,f8)")
def nose_rad(
    n_m_s: float,
    e_m_s: float,
    speed_min_m_s: float,
    own_n: float,
    own_e: float,
    watch: bool,
    watched_n: float,
    watched_e: float,
    fallback_rad: float,
) -> float:
    """Where the nose points: along a velocity above `speed_min_m_s`, else at a place to watch, else where it does already."""
    if math.hypot(n_m_s, e_m_s) > speed_min_m_s:
        return math.atan2(e_m_s, n_m_s)
    if watch and (watched_n != own_n or watched_e != own_e):
        return math.atan2(watched_e - own_e, watched_n - own_n)
    return fallback_rad
