"""Obstacles that mates have told: kept for a few seconds, given to the planner where nothing better is known.

They only ever add to what the own camera sees, and only for the planner: the supervisor, who can stop the vehicle, never hears of
them. What the own camera sees, it knows better: a disc of its own replaces what was told there, and a place that it sees to be
free refutes who says otherwise, for a while also after it looks elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flightapp.core.types import Array
from flightapp.fleet.messages.discs import Discs
from flightapp.fleet.sharing.choosing import RADIUS_MAX_M, STANDING_MAX_M_S, Mask, Presence

MEMORY_S = 4.0
"""Since a disc was last told, by when its sender saw it."""
REFUTED_S = 8.0
"""How long a place that was seen to be free is not believed to be occupied. Longer than the memory: repeating does not help."""
KEPT_MAX = 16
"""Of each sender: two messages of different discs."""
TAKEN_MAX = 12
"""Given to the planner, the nearest."""
COVERED_M = 0.3
"""Discs whose middles are nearer than the larger radius and this are the same thing, seen from two sides."""
NEAR_SIDE = 0.5
"""Of the radius: the middle of the near half of a disc must not be seen free either."""

Place = tuple[float, float]
IsFree = Callable[[float, float], bool]
"""Whether the own camera sees (north_m, east_m) to be free now."""


@dataclass(frozen=True, slots=True)
class _Told:
    """One disc: `told_s` when its sender saw it, own clock; `refuted_s` when the own camera last saw otherwise."""

    north_m: float
    east_m: float
    radius_m: float
    told_s: float
    refuted_s: float = -math.inf

    def is_same(self, other: _Told) -> bool:
        away_m = math.hypot(self.north_m - other.north_m, self.east_m - other.east_m)
        return away_m <= max(self.radius_m, other.radius_m)


class HeardDiscs:
    """Bounded in memory however much is told. Times are on the own clock; mission frame."""

    def __init__(self) -> None:
        self._told: dict[str, list[_Told]] = {}

    def take(self, sender: str, message: Discs, now_s: float) -> None:
        """What `sender` has told; what moves or is no obstacle of perception's size is passed over."""
        seen_s = min(message.t_s, now_s)
        kept, told = self._told.get(sender, []), []
        for disc in message.discs:
            if disc.radius_m > RADIUS_MAX_M or math.hypot(disc.v_north_m_s, disc.v_east_m_s) > STANDING_MAX_M_S:
                continue
            one = _Told(disc.north_m, disc.east_m, disc.radius_m, seen_s)
            told.append(replace(one, refuted_s=max((was.refuted_s for was in kept if was.is_same(one)), default=-math.inf)))
        others = [was for was in kept if not any(was.is_same(one) for one in told)]
        self._told[sender] = [*others, *told][-KEPT_MAX:]

    def look(self, now_s: float, own_m: Place, body_radius_m: float, is_free: IsFree | None) -> None:
        """Refute what stands where the own camera sees free space, or where the vehicle itself is; forget what is old."""
        for sender, kept in self._told.items():
            looked = [replace(one, refuted_s=now_s) if _is_refuted(one, own_m, body_radius_m, is_free) else one for one in kept]
            self._told[sender] = [one for one in looked if now_s - one.told_s <= MEMORY_S or now_s - one.refuted_s <= REFUTED_S]

    def unknown(self, now_s: float, own_m: Place, own_discs: Array, presences: Sequence[Presence]) -> Array:
        """(k, 3) north, east, radius of what was told and the own camera does not know: at most TAKEN_MAX, nearest first.

        own_discs: (n, >=3) what it knows. presences: vehicles, which are no obstacles whoever takes them for some.
        """
        found = np.zeros((0, 3))
        for kept in self._told.values():
            rows = [
                (one.north_m, one.east_m, one.radius_m)
                for one in kept
                if now_s - one.told_s <= MEMORY_S and now_s - one.refuted_s > REFUTED_S
            ]
            told = np.array(rows, dtype=np.float64).reshape(-1, 3)
            for presence in presences:
                told = told[~presence.may_be(told)]
            # One sender's own discs may lie close together: they are the parts of something large.
            found = np.vstack((found, told[~_are_covered(told, np.vstack((own_discs[:, :3], found)))]))
        gap_m = np.hypot(found[:, 0] - own_m[0], found[:, 1] - own_m[1]) - found[:, 2]
        return np.ascontiguousarray(found[np.argsort(gap_m, kind="stable")[:TAKEN_MAX]])


def _are_covered(discs: Array, known: Array) -> Mask:
    """Which of `discs` (n, 3) are what one of `known` (m, 3) is: (n,) bool."""
    away_m = np.hypot(discs[:, None, 0] - known[None, :, 0], discs[:, None, 1] - known[None, :, 1])
    covered = away_m <= np.maximum(discs[:, None, 2], known[None, :, 2]) + COVERED_M
    return np.asarray(covered.any(axis=1))


def _is_refuted(one: _Told, own_m: Place, body_radius_m: float, is_free: IsFree | None) -> bool:
    north_m, east_m = own_m[0] - one.north_m, own_m[1] - one.east_m
    away_m = math.hypot(north_m, east_m)
    if away_m <= one.radius_m + body_radius_m:
        return True
    if is_free is None:
        return False
    share = NEAR_SIDE * one.radius_m / away_m
    return is_free(one.north_m, one.east_m) or is_free(one.north_m + share * north_m, one.east_m + share * east_m)
