"""Planar velocity bounds: half-planes n . v <= b, and the velocity nearest to a wish that keeps all of them.

Every spatial guard states its rule as such bounds, so rules that act at the same time are solved together instead of undoing
one another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

EPSILON = 1e-9
RELAXATION_STEPS = 8

Planar = tuple[float, float]


class VelocityBound(NamedTuple):
    """(north, east) . velocity <= bound_m_s with a unit normal; a negative bound asks to move away.

    `what` is in the way and `distance_m` is left to it: for the reason that is recorded.
    """

    north: float
    east: float
    bound_m_s: float
    guard: str
    what: str
    distance_m: float

    def excess_m_s(self, velocity: Planar) -> float:
        """By how much `velocity` breaks the bound; negative inside."""
        return self.north * velocity[0] + self.east * velocity[1] - self.bound_m_s

    def reason(self) -> str:
        if self.bound_m_s < 0.0:
            return f"{self.what} {self.distance_m:.1f} m away comes closer: retreating at {-self.bound_m_s:.1f} m/s"
        return f"{self.what} {self.distance_m:.1f} m away: approaching it at no more than {self.bound_m_s:.1f} m/s"


def project(wish: Planar, bounds: Sequence[VelocityBound], speed_max_m_s: float) -> Planar:
    """The velocity nearest to `wish` that keeps all `bounds`, exact and deterministic.

    When no bound is negative, zero velocity keeps them all and the result is never faster than `wish`. When bounds that ask
    to move away contradict the others, all of those are weakened together by the least factor that leaves a solution: the
    vehicle retreats as fast as everything else lets it, and stops where nothing is left. Retreats end at `speed_max_m_s`.
    """
    solution = _nearest(wish, bounds)
    if solution is None:
        weakest, strongest = 0.0, 1.0
        solution = _nearest(wish, _weakened(bounds, 0.0)) or (0.0, 0.0)
        for _ in range(RELAXATION_STEPS):
            middle = 0.5 * (weakest + strongest)
            candidate = _nearest(wish, _weakened(bounds, middle))
            if candidate is None:
                strongest = middle
            else:
                weakest, solution = middle, candidate
    speed = math.hypot(*solution)
    if speed > speed_max_m_s:
        return (solution[0] * speed_max_m_s / speed, solution[1] * speed_max_m_s / speed)
    return solution


def _weakened(bounds: Sequence[VelocityBound], factor: float) -> list[VelocityBound]:
    return [bound._replace(bound_m_s=bound.bound_m_s * factor) if bound.bound_m_s < 0.0 else bound for bound in bounds]


def _nearest(wish: Planar, bounds: Sequence[VelocityBound]) -> Planar | None:
    """Incremental planar quadratic program: the optimum moves onto each bound that it breaks, clipped by the earlier ones."""
    velocity = wish
    for index, (north, east, bound, _, _, _) in enumerate(bounds):
        if north * velocity[0] + east * velocity[1] <= bound + EPSILON:
            continue
        foot_north, foot_east = north * bound, east * bound
        along_north, along_east = -east, north
        low, high = -math.inf, math.inf
        for other_north, other_east, other_bound, _, _, _ in bounds[:index]:
            slope = other_north * along_north + other_east * along_east
            room = other_bound - other_north * foot_north - other_east * foot_east
            if slope > EPSILON:
                high = min(high, room / slope)
            elif slope < -EPSILON:
                low = max(low, room / slope)
            elif room < -EPSILON:
                return None
        if low > high:
            if low - high > 1e-6:
                return None
            low = high = 0.5 * (low + high)
        along = min(max(along_north * wish[0] + along_east * wish[1], low), high)
        velocity = (foot_north + along * along_north, foot_east + along * along_east)
    return velocity
