"""Shortest way around inflated discs: Dijkstra on the visibility graph of polygons around them."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse.csgraph import dijkstra

from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

CORNERS = 24
"""Of the polygon around a disc: its perimeter is 1 % longer than the circle's."""


def shortest_path_m(start: tuple[float, float], goal: tuple[float, float], discs: Array, inflation_m: float) -> float | None:
    """Length of the shortest way of a point that keeps `inflation_m` from `discs` (n, >=3); None where there is none.

    At most 1 % too long: the way follows polygons of `CORNERS` corners around the inflated discs.
    """
    round_ = np.ascontiguousarray(discs[:, :3]).copy()
    round_[:, 2] += inflation_m
    places = np.vstack((np.array([start, goal]), _corners(round_)))
    lengths = np.zeros((len(places), len(places)))
    _visible_lengths(places, round_, lengths)
    found = float(dijkstra(lengths, directed=False, indices=[0])[0, 1])
    return found if math.isfinite(found) else None


def _corners(round_: Array) -> Array:
    """Corners (k, 2) of the polygons around the discs that are in no other disc."""
    angles = np.arange(CORNERS) * (2.0 * math.pi / CORNERS)
    reach = round_[:, 2] / math.cos(math.pi / CORNERS) + 1e-6
    corners = round_[:, None, :2] + reach[:, None, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    corners = corners.reshape(-1, 2)
    gap = np.hypot(corners[:, None, 0] - round_[:, 0], corners[:, None, 1] - round_[:, 1]) - round_[:, 2]
    return np.asarray(corners[(gap >= 0.0).all(axis=1)])


@compiled("void(f8[:,::1],f8[:,::1],f8[:,::1])")
def _visible_lengths(places: Array, discs: Array, lengths: Array) -> None:
    """lengths (k, k), upper half: distance of each two places that see each other past the discs, else 0."""
    blocking = 0
    for i in range(len(places)):
        for j in range(i + 1, len(places)):
            n, e = places[i, 0], places[i, 1]
            dn, de = places[j, 0] - n, places[j, 1] - e
            free = True
            for step in range(len(discs)):
                k = blocking if step == 0 else (step - 1 if step <= blocking else step)  # most often the same one blocks again
                on, oe = discs[k, 0] - n, discs[k, 1] - e
                fraction = nearest_share(-on, -oe, dn, de)
                gap_n, gap_e = on - fraction * dn, oe - fraction * de
                if gap_n * gap_n + gap_e * gap_e < discs[k, 2] * discs[k, 2]:
                    free = False
                    blocking = k
                    break
            lengths[i, j] = math.sqrt(dn * dn + de * de) if free else 0.0
