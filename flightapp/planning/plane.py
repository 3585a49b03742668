"""Small planar geometry on (north, east) tuples, in metres; used once a control period where arrays would cost more."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from flightapp.core.clearance import nearest_share
from flightapp.core.types import Array, Boundary

Point = tuple[float, float]
Segment = tuple[Point, Point]


def planar(vector: Array) -> Point:
    """North and east of a (2,) or (3,) vector as plain floats."""
    return float(vector[0]), float(vector[1])


def unit(vector: Point) -> Point:
    """`vector` at length 1; (0, 0) stays."""
    length = math.hypot(*vector)
    return (vector[0] / length, vector[1] / length) if length > 0.0 else (0.0, 0.0)


def limited(vector: Point, length_max: float) -> Point:
    """`vector`, shortened to `length_max` where it is longer."""
    length = math.hypot(*vector)
    if length <= length_max:
        return vector
    return vector[0] * length_max / length, vector[1] * length_max / length


def towards(start: Point, goal: Point) -> Point:
    """Unit vector from `start` to `goal`."""
    return unit((goal[0] - start[0], goal[1] - start[1]))


def segments(boundary: Boundary) -> tuple[Segment, ...]:
    """The sides of `boundary`, in order."""
    corners = [planar(vertex) for vertex in boundary.vertices_m]
    if boundary.closed:
        corners.append(corners[0])
    return tuple(itertools.pairwise(corners))


def nearest_on_segment(point: Point, segment: Segment) -> Point:
    """The point of `segment` nearest to `point`."""
    (an, ae), (bn, be) = segment
    dn, de = bn - an, be - ae
    fraction = nearest_share(an - point[0], ae - point[1], dn, de)
    return an + fraction * dn, ae + fraction * de


def nearest_on(point: Point, sides: Sequence[Segment]) -> Point:
    """The point of a polyline nearest to `point`."""
    return min((nearest_on_segment(point, side) for side in sides), key=lambda found: math.dist(found, point))


def crosses(start: Point, end: Point, sides: Sequence[Segment]) -> bool:
    """Whether the way `start` -> `end` meets the polyline `sides`; arriving on it counts, moving along it does not."""
    for a, b in sides:
        before, after = _side_of(a, b, start), _side_of(a, b, end)
        if before != after and before * after <= 0.0 and _side_of(start, end, a) * _side_of(start, end, b) <= 0.0:
            return True
    return False


def _side_of(a: Point, b: Point, point: Point) -> float:
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
