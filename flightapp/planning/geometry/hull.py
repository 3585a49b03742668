"""Distance to the convex hull of a few points: whether a team encircles an evader, and how far from it it is.

Wang et al., "OA-ECBVC", arXiv 2312.01326, eq. 1, with the distance inside taken to the hull's border: their minimum over the
hull is 0 for every point inside it.
"""

from __future__ import annotations

import math

from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

ON_A_LINE_M = 1e-9


@compiled("f8(f8[:,::1],f8,f8)")
def hull_distance_m(points: Array, n: float, e: float) -> float:
    """From (n, e) to the hull of `points` (k, 2); inside, minus the distance to its border; inf without points.

    Never negative for fewer than three points, or points on one line: they enclose nothing. O(k^3): for a team.
    """
    count = points.shape[0]
    outside = math.inf
    inside = math.inf
    encloses = True
    has_area = False
    for i in range(count):
        outside = min(outside, math.hypot(points[i, 0] - n, points[i, 1] - e))
        for j in range(i + 1, count):
            dn = points[j, 0] - points[i, 0]
            de = points[j, 1] - points[i, 1]
            length = math.hypot(dn, de)
            if length < ON_A_LINE_M:
                continue
            share = nearest_share(points[i, 0] - n, points[i, 1] - e, dn, de)
            gap = math.hypot(points[i, 0] + share * dn - n, points[i, 1] + share * de - e)
            outside = min(outside, gap)
            most = 0.0
            least = 0.0
            for k in range(count):
                side = ((points[k, 0] - points[i, 0]) * de - (points[k, 1] - points[i, 1]) * dn) / length
                most = max(most, side)
                least = min(least, side)
            if least < -ON_A_LINE_M and most > ON_A_LINE_M:
                continue  # the hull is on both sides: no border
            if most > ON_A_LINE_M or least < -ON_A_LINE_M:
                has_area = True
                own = ((n - points[i, 0]) * de - (e - points[i, 1]) * dn) / length
                depth = own if most > ON_A_LINE_M else -own
                encloses = encloses and depth >= 0.0
                inside = min(inside, depth)
    return -inside if has_area and encloses else outside
