"""The simulated world as it truly is: vertical cylinders and boxes standing on flat ground."""

from __future__ import annotations

import math

import numpy as np

from flightapp.config.mission import Obstacles
from flightapp.core.clearance import NO_OBSTACLE_M, gap_m
from flightapp.core.types import Array
from perception.kernel_cache import njit

_SAMPLE_STEP_M = 0.02
_BOX_CELL_M = 0.75
_BOX_OVERHANG_M = 0.16


class World:
    """Obstacles of a mission in the mission frame.

    cylinders: (n, 4) north_m, east_m, radius_m, height_m. boxes: (m, 6) north_m, east_m, length_m (along the heading), width_m,
    height_m, heading_rad. Both stand on the ground plane at `ground_down_m`. capsules: none, a mission has no branches or wires.
    """

    def __init__(self, obstacles: Obstacles, ground_down_m: float = 0.0) -> None:
        self.ground_down_m = ground_down_m
        self.cylinders: Array = np.array(
            [(c.north_m, c.east_m, c.radius_m, c.height_m) for c in obstacles.cylinders], np.float64
        ).reshape(-1, 4)
        self.boxes: Array = np.array(
            [(b.north_m, b.east_m, b.length_m, b.width_m, b.height_m, math.radians(b.heading_deg)) for b in obstacles.boxes],
            np.float64,
        ).reshape(-1, 6)
        self.capsules: Array = np.zeros((0, 7))

    def signed_distance_m(self, north_m: float, east_m: float, down_m: float) -> float:
        """Distance of a point to the nearest true surface, negative inside an obstacle; NO_OBSTACLE_M in an empty world.

        Planar while the point is at the height of the obstacle, in three dimensions above it. The ground does not count.
        """
        return float(_signed_distance(north_m, east_m, down_m, self.ground_down_m, self.cylinders, self.boxes))

    def segment_clearance_m(self, start_ned_m: Array, end_ned_m: Array, body_radius_m: float = 0.0) -> float:
        """Smallest clearance of a body that moves straight from `start_ned_m` to `end_ned_m` (3,).

        Samples every 2 cm and takes off half a step: never more than the true value, at most 1 cm less.
        """
        start = np.ascontiguousarray(start_ned_m, np.float64)
        end = np.ascontiguousarray(end_ned_m, np.float64)
        distance = _segment_distance(start, end, self.ground_down_m, self.cylinders, self.boxes)
        return float(distance) - body_radius_m

    def as_discs(self) -> Array:
        """Discs (n, 7) in ObstacleSet's columns that cover every obstacle: a cylinder is one, a box many small ones.

        No disc stands out of its box by more than a quarter of a metre.
        """
        discs = [(n, e, radius, self.ground_down_m - height) for n, e, radius, height in self.cylinders.tolist()]
        for north, east, length, width, height, heading in self.boxes.tolist():
            cos, sin = math.cos(heading), math.sin(heading)
            discs.extend(
                (north + along * cos - across * sin, east + along * sin + across * cos, radius, self.ground_down_m - height)
                for along, across, radius in _cover_rectangle(length, width)
            )
        out = np.zeros((len(discs), 7))
        if discs:
            out[:, [0, 1, 2, 5]] = discs
        out[:, 6] = self.ground_down_m
        return out


def _cover_rectangle(length: float, width: float) -> list[tuple[float, float, float]]:
    """Circles (along, across, radius) that cover a rectangle about the origin: a ring of small ones, larger ones inside."""
    thin = min(length, width)
    thin /= math.ceil(thin / _BOX_CELL_M)
    longest = min(_BOX_CELL_M, math.sqrt((thin + 2 * _BOX_OVERHANG_M) ** 2 - thin**2))
    n_long, n_wide = (math.ceil(side / (longest if side > thin else thin)) for side in (length, width))
    cell_l, cell_w = length / n_long, width / n_wide
    radius = math.hypot(cell_l, cell_w) / 2
    circles = [
        ((i + 0.5) * cell_l - length / 2, (j + 0.5) * cell_w - width / 2, radius)
        for i in range(n_long)
        for j in range(n_wide)
        if i in (0, n_long - 1) or j in (0, n_wide - 1)
    ]
    inner_l, inner_w = length - 2 * cell_l, width - 2 * cell_w
    if n_long > 2 and n_wide > 2:
        # Circles around cells of up to 2:1 with the longer side c stick out by 0.31 c; the ring leaves room for c = 3 cells.
        cell = min(cell_l, cell_w)
        side = min(3 * cell, max(inner_l, cell), max(inner_w, cell))
        m_long, m_wide = math.ceil(inner_l / side), math.ceil(inner_w / side)
        step_l, step_w = inner_l / m_long, inner_w / m_wide
        circles.extend(
            ((i + 0.5) * step_l - inner_l / 2, (j + 0.5) * step_w - inner_w / 2, math.hypot(step_l, step_w) / 2)
            for i in range(m_long)
            for j in range(m_wide)
        )
    return circles


@njit("f8(f8,f8)", cache=True, nogil=True)
def _with_height(planar, above_top):  # type: ignore[no-untyped-def]
    """Distance to an upright body from the planar distance to its outline and the height above its top."""
    return planar if above_top <= 0.0 else math.hypot(max(planar, 0.0), above_top)


@njit("f8(f8,f8,f8,f8,f8[:,::1],f8[:,::1])", cache=True, nogil=True)
def _signed_distance(north, east, down, ground, cylinders, boxes):  # type: ignore[no-untyped-def]
    nearest = NO_OBSTACLE_M
    for i in range(cylinders.shape[0]):
        planar = gap_m(north - cylinders[i, 0], east - cylinders[i, 1], cylinders[i, 2])
        nearest = min(nearest, _with_height(planar, (ground - cylinders[i, 3]) - down))
    for i in range(boxes.shape[0]):
        n, e = north - boxes[i, 0], east - boxes[i, 1]
        cos, sin = math.cos(boxes[i, 5]), math.sin(boxes[i, 5])
        along = abs(n * cos + e * sin) - boxes[i, 2] / 2
        across = abs(e * cos - n * sin) - boxes[i, 3] / 2
        planar = math.hypot(max(along, 0.0), max(across, 0.0)) + min(max(along, across), 0.0)
        nearest = min(nearest, _with_height(planar, (ground - boxes[i, 4]) - down))
    return nearest


@njit("f8(f8[::1],f8[::1],f8,f8[:,::1],f8[:,::1])", cache=True, nogil=True)
def _segment_distance(start, end, ground, cylinders, boxes):  # type: ignore[no-untyped-def]
    length = math.sqrt((end[0] - start[0]) ** 2 + (end[1] - start[1]) ** 2 + (end[2] - start[2]) ** 2)
    steps = math.ceil(length / _SAMPLE_STEP_M)
    nearest = NO_OBSTACLE_M
    for k in range(steps + 1):
        part = k / steps if steps else 0.0
        north = start[0] + part * (end[0] - start[0])
        east = start[1] + part * (end[1] - start[1])
        down = start[2] + part * (end[2] - start[2])
        nearest = min(nearest, _signed_distance(north, east, down, ground, cylinders, boxes))
    return nearest - (length / steps / 2 if steps else 0.0)
