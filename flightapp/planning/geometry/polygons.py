"""Convex obstacles as somebody writes them down, made fit for `half_planes.add_polygons`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array

AREA_CHANGE_MAX = 0.01
"""Share of its area that a polygon may gain by its convex hull before that is worth a warning."""


@dataclass(frozen=True, slots=True)
class Polygons:
    """Convex polygons one after the other; the k-th has the corners from starts[k] to starts[k + 1]."""

    corners: Array  # (c, 2) north, east, anticlockwise in (north, east)
    starts: NDArray[np.int64]  # (k + 1,)
    warnings: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        return len(self.starts) - 1


def polygons(given: Sequence[Sequence[Sequence[float]]]) -> Polygons:
    """The convex hull of each of `given` (corners as north, east in m, in any order of turning, repeated or on one line).

    A polygon without area becomes a segment. ValueError on one without two different places, or with a number that is not finite.
    """
    import shapely

    rows: list[Array] = []
    warnings: list[str] = []
    for number, corners in enumerate(given):
        places = np.array(corners, dtype=np.float64).reshape(-1, 2)
        if not np.isfinite(places).all():
            raise ValueError(f"polygon {number}: every corner must be a finite north, east")
        hull = shapely.MultiPoint(places).convex_hull
        if hull.geom_type == "Point" or hull.is_empty:
            raise ValueError(f"polygon {number}: its corners are one place; give at least two, a disc is no polygon")
        if hull.geom_type == "LineString":
            rows.append(np.asarray(hull.coords))
            continue
        rows.append(np.asarray(shapely.orient_polygons(hull).exterior.coords)[:-1])
        before = shapely.Polygon(places).buffer(0).area if len(places) > 2 else 0.0
        if hull.area > (1.0 + AREA_CHANGE_MAX) * before:
            warnings.append(
                f"polygon {number} is not convex: its hull of {hull.area:.2f} m2 is avoided instead of {before:.2f} m2"
            )
    starts = np.cumsum([0, *map(len, rows)]).astype(np.int64)
    return Polygons(np.ascontiguousarray(np.concatenate(rows) if rows else np.zeros((0, 2))), starts, tuple(warnings))
