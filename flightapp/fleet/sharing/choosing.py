"""Which of the obstacles that the own camera sees are worth telling the others: what stands where they, or the target, will fly.

Never a vehicle: a disc that moves, that touches the place of a vehicle, or that is small enough to be one whose place is not
known well, is kept back. When in doubt nothing is told: whoever is not told flies by its own camera, as it would anyway.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.fleet.messages.discs import Disc

Mask = NDArray[np.bool_]

TOLD_MAX = 8
"""So many once a second are what the fleet's budget counts (tools/fleet_traffic.py)."""
CONFIDENCE_MIN = 0.9
"""The tracker's: two sightings of a whole and near thing give 0.75, four 0.94."""
AGE_MAX_S = 1.0
"""What left the picture since the last telling is told once more; it is not told from memory for ever."""
STANDING_MAX_M_S = 0.2
RADIUS_MAX_M = 2.0
"""Perception covers what is larger with several discs."""
BESIDE_WAY_M = 4.0
"""From a disc's surface to a straight way: who has to fly around something else still meets it."""
IN_SIGHT_M = 6.0
"""What is so near a mate, that one probably sees itself: it is told last."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What the own camera knows. discs (n, >=5), columns DISC_COLUMNS, mission frame; age_s, confidence (n,) of each."""

    discs: Array
    age_s: Array
    confidence: Array


@dataclass(frozen=True, slots=True)
class Presence:
    """A vehicle where it is known to be: whatever touches `touching_m` around it may be the vehicle itself.

    What is no larger than `size_m` may also be it as far away as `possible_m`.
    """

    north_m: float
    east_m: float
    touching_m: float
    size_m: float
    possible_m: float

    def may_be(self, discs: Array) -> Mask:
        """Which of `discs` (n, >=3) may be this vehicle: (n,) bool."""
        away_m = np.hypot(discs[:, 0] - self.north_m, discs[:, 1] - self.east_m)
        touches = away_m <= discs[:, 2] + self.touching_m
        return np.asarray(touches | ((discs[:, 2] <= self.size_m) & (away_m <= discs[:, 2] + self.possible_m)))


@dataclass(frozen=True, slots=True)
class Way:
    """Straight, of a mate to where it wants to be or of the target as it is predicted; (north, east), mission frame."""

    start_m: tuple[float, float]
    end_m: tuple[float, float]

    def beside_m(self, discs: Array) -> Array:
        """From the surface of each of `discs` (n, >=3) to the nearest point of the way: (n,), below 0 on it."""
        start, along = np.array(self.start_m), np.subtract(self.end_m, self.start_m)
        offset = discs[:, :2] - start
        share = np.clip(offset @ along / max(float(along @ along), 1e-9), 0.0, 1.0)
        off_way = offset - share[:, None] * along
        return np.asarray(np.hypot(off_way[:, 0], off_way[:, 1]) - discs[:, 2])

    def ahead_m(self, discs: Array) -> Array:
        """From the start to the surface of each of `discs`: (n,)."""
        return np.asarray(np.hypot(discs[:, 0] - self.start_m[0], discs[:, 1] - self.start_m[1]) - discs[:, 2])


def worth_telling(seen: Seen, presences: Sequence[Presence], ways: Sequence[Way]) -> tuple[Disc, ...]:
    """At most TOLD_MAX, what others meet first and probably do not see themselves before all else; empty without `ways`.

    presences: of every vehicle that may be in sight. ways: the mates' and the target's, not the own.
    """
    discs = seen.discs
    if not len(discs) or not ways:
        return ()
    beside_m = np.array([way.beside_m(discs) for way in ways])
    ahead_m = np.where(beside_m <= BESIDE_WAY_M, np.array([way.ahead_m(discs) for way in ways]), math.inf)
    first_m = ahead_m.min(axis=0)
    unseen_m = np.where(ahead_m > IN_SIGHT_M, ahead_m, math.inf).min(axis=0)
    is_worth = _is_sure(seen) & np.isfinite(first_m)
    for presence in presences:
        is_worth &= ~presence.may_be(discs)
    order = np.lexsort((first_m, unseen_m))
    return tuple(_disc(discs[place]) for place in order.tolist() if is_worth[place])[:TOLD_MAX]


def _is_sure(seen: Seen) -> Mask:
    """Seen well and lately, standing, and of a size that perception gives: (n,) bool."""
    discs = seen.discs
    sure = (seen.confidence >= CONFIDENCE_MIN) & (seen.age_s <= AGE_MAX_S) & np.isfinite(discs[:, :5]).all(axis=1)
    stands = np.hypot(discs[:, 3], discs[:, 4]) <= STANDING_MAX_M_S
    return np.asarray(sure & stands & (discs[:, 2] > 0.0) & (discs[:, 2] <= RADIUS_MAX_M))


def _disc(row: Array) -> Disc:
    return Disc(float(row[0]), float(row[1]), float(row[2]), 0.0, 0.0)
