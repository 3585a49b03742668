"""`oa-ecbvc`: the centroid of the cell around the evader (Wang et al., arXiv 2312.01326, section III-C)."""

from __future__ import annotations

from flightapp.planning.encirclement.moment import Moment
from flightapp.planning.geometry.convex import AREA_MIN_M2
from flightapp.planning.plane import Point


def cell_centroid(moment: Moment) -> Point:
    """The target cell's centroid; without a cell the nearest to the evader that is safe: who stays is left behind by the box."""
    found = moment.cells
    if found.target_area_m2 >= AREA_MIN_M2:
        return found.centroid_n, found.centroid_e
    return found.near_evader_n, found.near_evader_e
