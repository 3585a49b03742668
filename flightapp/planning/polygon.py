"""Slots of a regular polygon about a place, and who takes which (CPPPEA, 2.13 of Li et al. 2025)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from flightapp.core.clearance import disc_clearances_m
from flightapp.core.types import Array

EXCHANGE_SHARE = 0.1
"""Slots are exchanged for a total way that is shorter by more than this."""
ROTATION_STEP_RAD = math.radians(5.0)
GROWTHS = (1.0, 1.25, 1.5)


@dataclass(frozen=True, slots=True)
class Bodies:
    """What must keep apart, in m."""

    pursuer_radius_m: float
    target_radius_m: float
    separation_m: float
    """Between surfaces on the ring."""

    def __post_init__(self) -> None:
        """ValueError where the ring could not be told."""
        if min(self.pursuer_radius_m, self.target_radius_m) < 0.0 or self.separation_m <= 0.0:
            raise ValueError("radii must be 0 or more, separation_m more than 0")

    def ring_radius_m(self, count: int, wanted_m: float) -> float:
        """The radius for `count` slots: `wanted_m`, or what target and neighbours need. Neighbours are a chord apart."""
        near = self.pursuer_radius_m + self.target_radius_m + self.separation_m
        apart = 2.0 * self.pursuer_radius_m + self.separation_m
        beside = apart / (2.0 * math.sin(math.pi / count)) if count > 1 else 0.0
        return max(near, beside, wanted_m)

    def slots_max(self, radius_m: float) -> int:
        """How many fit on a ring of `radius_m`."""
        share = (2.0 * self.pursuer_radius_m + self.separation_m) / (2.0 * radius_m)
        return 1 if share > 1.0 else math.floor(math.pi / math.asin(share) + 1e-9)


def slot_bearings_rad(count: int, heading_rad: float) -> Array:
    """(count,) rad from the centre; the first dead ahead of a target that moves along `heading_rad`.

    An even number leaves the way in free, turned by half a step; two are ahead and behind, one is behind.
    """
    offset = math.pi if count == 1 else math.pi / count if count % 2 == 0 and count > 2 else 0.0
    return heading_rad + offset + np.arange(count, dtype=np.float64) * (2.0 * math.pi / count)


def places_on_ring_m(centre_m: Array, radius_m: float, bearings_rad: Array) -> Array:
    """(n, 2) m."""
    return centre_m + radius_m * np.stack((np.cos(bearings_rad), np.sin(bearings_rad)), axis=-1)


@dataclass(frozen=True, slots=True)
class Ring:
    """Slots about a place."""

    radius_m: float
    bearings_rad: Array  # (n,)
    places_m: Array  # (n, 2)


def free_ring(centre_m: Array, heading_rad: float, count: int, wanted_m: float, bodies: Bodies, discs: Array) -> Ring:
    """The polygon, turned or grown where slots would be inside `discs` (m, >=3); slots without any free place are left out.

    Never fewer than one: where all are taken, the polygon as it would be without obstacles.
    """
    radius_m = bodies.ring_radius_m(count, wanted_m)
    turns = [sign * k * ROTATION_STEP_RAD for k in range(int(math.pi / count / ROTATION_STEP_RAD) + 1) for sign in (1, -1)][1:]
    most: Ring | None = None
    for growth in GROWTHS:
        for turn in turns:
            bearings = slot_bearings_rad(count, heading_rad) + turn
            places = places_on_ring_m(centre_m, growth * radius_m, bearings)
            free = _are_free(places, discs, bodies.pursuer_radius_m)
            if free.all():
                return Ring(growth * radius_m, bearings, places)
            if most is None or free.sum() > len(most.places_m):
                most = Ring(growth * radius_m, bearings[free], places[free])
    if most is not None and len(most.places_m):
        return most
    bearings = slot_bearings_rad(count, heading_rad)
    return Ring(radius_m, bearings, places_on_ring_m(centre_m, radius_m, bearings))


def _are_free(places_m: Array, discs: Array, body_radius_m: float) -> Array:
    if not len(discs):
        return np.ones(len(places_m), dtype=bool)
    return np.array([disc_clearances_m(place, discs, body_radius_m).min() > 0.0 for place in places_m])


def assign_slots(places_m: Array, slots_m: Array, names: Sequence[str], before: Mapping[str, int]) -> list[int | None]:
    """The slot of each vehicle at `places_m` (n, 2): least total way, so that no two ways cross; None for who gets none.

    `before` stays, name -> slot, as long as another is not worth the exchange. Names are in order, so that ties are the same
    everywhere.
    """
    ways = np.hypot(*(places_m[:, None, :] - slots_m[None, :, :]).transpose(2, 0, 1))
    rows, columns = linear_sum_assignment(ways)
    chosen: list[int | None] = [None] * len(places_m)
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        chosen[row] = column
    kept = [before.get(name) for name in names]
    taken = [slot for slot in kept if slot is not None]
    whole = len(taken) == len(rows) == len(set(taken)) and all(slot < len(slots_m) for slot in taken)
    if whole:
        stays = sum(ways[row, slot] for row, slot in enumerate(kept) if slot is not None)
        if ways[rows, columns].sum() > (1.0 - EXCHANGE_SHARE) * stays:
            return kept
    return chosen
