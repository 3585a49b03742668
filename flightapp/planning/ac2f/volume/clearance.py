"""Which obstacles stand in the way of a vehicle at its height, and how fast it may climb and sink among the others.

Heights are known where `down_top_m` and `down_bottom_m` are finite; -inf and +inf stand in the way at every height.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array, ObstacleSet
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.ac2f.volume.parameters import VolumeParameters

TOP, BOTTOM = 5, 6
"""Columns of discs; the columns before are the place, the radius and the velocity."""
SAME_M = 0.35
"""A disc whose centre is this near to an observed one is that one."""
STANDING_M_S = 0.3
"""Faster discs are not remembered."""
PASSED_SHARE = 0.7
"""Of the margin: an obstacle is passed above or below with this much of it, so that one that is kept to exactly does not come
and go with the noise of the height."""

REACTED_SHARE = 0.5
"""Of the reaction time that is still to come where the present motion is judged: it follows what was asked for before."""


class HeightMemory:
    """Obstacles of known height that have left the view: below a vehicle that flies over them, none sees them."""

    def __init__(self, memory_s: float) -> None:
        self._memory_s = memory_s
        self._rows = np.zeros((0, 8))

    def with_remembered(self, obstacles: ObstacleSet) -> Array:
        """(n + k, 7): the observed discs, then those that were seen before and not now."""
        discs = obstacles.discs
        old = self._rows[obstacles.t_s - self._rows[:, 7] <= self._memory_s]
        if len(discs) and len(old):
            apart = np.hypot(old[:, None, 0] - discs[None, :, 0], old[:, None, 1] - discs[None, :, 1])
            old = old[(apart > SAME_M).all(axis=1)]
        is_known = np.isfinite(discs[:, TOP]) | np.isfinite(discs[:, BOTTOM])
        seen = discs[is_known & (np.hypot(discs[:, 3], discs[:, 4]) <= STANDING_M_S)]
        self._rows = np.concatenate((np.column_stack((seen, np.full(len(seen), obstacles.t_s))), old))
        return np.concatenate((discs, old[:, :7]))


@dataclass(frozen=True, slots=True)
class VerticalRoom:
    """blocking: (n,) which discs stand in the way. The rates are the most that keep the vehicle clear of the others, >= 0."""

    blocking: NDArray[np.bool_]
    climb_max_m_s: float
    sink_max_m_s: float


def stopping_m(speed_m_s: float, deceleration_m_s2: float, reaction_s: float) -> float:
    """Way from `speed_m_s` to rest; 0 for none towards it."""
    speed = max(0.0, speed_m_s)
    return speed * reaction_s + speed * speed / (2.0 * deceleration_m_s2)


def vertical_room(
    discs: Array, offsets_m: Array, down_m: float, down_m_s: float, near_m: float, parameters: VolumeParameters
) -> VerticalRoom:
    """For a vehicle at `down_m` that moves down with `down_m_s`.

    discs: (n, 7); offsets_m: (n,) planar distance of their surfaces from the own centre. A disc is passed above or below where
    what the vehicle sweeps until its vertical motion could have ended stays clear of it. Those that are passed and nearer than
    `near_m`, from where the planar motion could not go around them any more, limit the rates: it is never sunk into one.
    """
    braking, reaction, margin = parameters.acceleration_max_m_s2, parameters.reaction_s, parameters.obstacle_margin_m
    above = discs[:, TOP] - down_m - margin
    below = down_m - discs[:, BOTTOM] - margin
    spared = (1.0 - PASSED_SHARE) * margin
    over = above + spared >= stopping_m(down_m_s, braking, REACTED_SHARE * reaction)
    under = below + spared >= stopping_m(-down_m_s, braking, REACTED_SHARE * reaction)
    near = offsets_m <= near_m
    floor = float(above[over & near].min(initial=np.inf))
    ceiling = float(below[under & near].min(initial=np.inf))
    floor = min(floor, -parameters.height_min_m - down_m)
    ceiling = min(ceiling, down_m + parameters.height_max_m)
    return VerticalRoom(
        ~(over | under),
        braking_speed_m_s(ceiling, braking, reaction) if np.isfinite(ceiling) else np.inf,
        braking_speed_m_s(floor, braking, reaction) if np.isfinite(floor) else np.inf,
    )
