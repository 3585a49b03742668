"""Planar velocity bounds: half-planes n . v <= b, and the velocity nearest to a wish that keeps all of them.

Every spatial guard states its rule as such bounds, so rules that act at the same time are solved together instead of undoing
one another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from flightapp.core.types import Array
from perception.kernel_cache import njit

EPSILON = 1e-9
RELAXATION_STEPS = 8

Planar = tuple[float, float]


class VelocityBound(NamedTuple):
    """(north, east) . velocity <= bound_m_s with a unit normal; a negative bound asks to move away.

    `what` is in the way and `distance_m` is left to it: for the reason that is recorded, which `text` replaces.
    """

    north: float
    east: float
    bound_m_s: float
    guard: str
    what: str
    distance_m: float
    text: str = ""

    def excess_m_s(self, velocity: Planar) -> float:
        """By how much `velocity` breaks the bound; negative inside."""
        return self.north * velocity[0] + self.east * velocity[1] - self.bound_m_s

    def reason(self) -> str:
        if self.text:
            return self.text
        if self.bound_m_s < 0.0:
            return f"{self.what} {self.distance_m:.1f} m away: too close, retreating at {-self.bound_m_s:.1f} m/s"
        return f"{self.what} {self.distance_m:.1f} m away: approaching it at no more than {self.bound_m_s:.1f} m/s"


def project(wish: Planar, bounds: Sequence[VelocityBound], speed_max_m_s: float) -> Planar:
    """The velocity nearest to `wish` that keeps all `bounds`, exact and deterministic.

    When no bound is negative, zero velocity keeps them all and the result is never faster than `wish`. When bounds that ask
    to move away contradict the others, all of those are weakened together by the least factor that leaves a solution: the
    vehicle retreats as fast as everything else lets it, and stops where nothing is left. Retreats end at `speed_max_m_s`.
    """
    rows = np.array([bound[:3] for bound in bounds], dtype=np.float64).reshape(-1, 3)
    north, east = _project(rows, wish[0], wish[1], speed_max_m_s)
    return float(north), float(east)


@njit("UniTuple(f8,3)(f8[:,::1],f8,f8,f8)", cache=True)
def _nearest(rows: Array, wish_north: float, wish_east: float, retreat: float) -> tuple[float, float, float]:
    """Incremental planar quadratic program: the optimum moves onto each bound that it breaks, clipped by the earlier ones.

    rows (n, 3): north, east, bound m/s; negative bounds count by the factor `retreat`. Returns (north, east, 1.0), or a third
    element of 0.0 where no velocity keeps all bounds.
    """
    v_north, v_east = wish_north, wish_east
    for index in range(len(rows)):
        north, east, bound = rows[index]
        bound *= retreat if bound < 0.0 else 1.0
        if north * v_north + east * v_east <= bound + EPSILON:
            continue
        along_north, along_east = -east, north
        low, high = -math.inf, math.inf
        for earlier in range(index):
            other_north, other_east, other_bound = rows[earlier]
            other_bound *= retreat if other_bound < 0.0 else 1.0
            slope = other_north * along_north + other_east * along_east
            room = other_bound - (other_north * north + other_east * east) * bound
            if slope > EPSILON:
                high = min(high, room / slope)
            elif slope < -EPSILON:
                low = max(low, room / slope)
            elif room < -EPSILON:
                return 0.0, 0.0, 0.0
        if low > high:
            if low - high > 1e-6:
                return 0.0, 0.0, 0.0
            low = high = 0.5 * (low + high)
        along = min(max(along_north * wish_north + along_east * wish_east, low), high)
        v_north, v_east = north * bound + along * along_north, east * bound + along * along_east
    return v_north, v_east, 1.0


@njit("UniTuple(f8,2)(f8[:,::1],f8,f8,f8)", cache=True)
def _project(rows: Array, wish_north: float, wish_east: float, speed_max: float) -> tuple[float, float]:
    north, east, solved = _nearest(rows, wish_north, wish_east, 1.0)
    if solved == 0.0:
        weakest, strongest = 0.0, 1.0
        north, east, solved = _nearest(rows, wish_north, wish_east, 0.0)
        for _ in range(RELAXATION_STEPS):
            middle = 0.5 * (weakest + strongest)
            v_north, v_east, solved = _nearest(rows, wish_north, wish_east, middle)
            if solved == 0.0:
                strongest = middle
            else:
                weakest, north, east = middle, v_north, v_east
    speed = math.hypot(north, east)
    scale = speed_max / speed if speed > speed_max else 1.0
    return north * scale, east * scale
