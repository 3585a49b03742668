"""The pass over the pixels: those that show something in the vehicle's way are counted into the polar grid.

Only measured pixels are used, none is averaged with its neighbour: between a pole and the wall behind it there is nothing.
What is nearer is sampled less densely, because it shows more pixels: from 2.5 m inwards every second, from 1.25 m inwards every
fourth of the used rows, each counting for those left out.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.extraction.height_band import HeightBand
from perception.extraction.polar_grid import TABLE_STEP_M, DistanceCells
from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.parameters import PerceptionParameters
from perception.types import DepthFrame, Intrinsics

_ALIKE_SIGMAS = 3.0
_ALIKE_M = 0.02
_ALIKE_PIXELS_MIN = 2
"""A pixel counts if this many of the four next to it are at its depth, give or take the noise: speckle and the pixels that fly
between a near edge and what is behind it stand alone, the thinnest pole or branch does not."""
_DENSE_M = 2.5
_FORWARD_MIN_M = 0.05
_EDGE_ROWS = 4
"""Of the nearest, only every fourth row is used."""

COUNT_SHIFT = 40
SUM_MASK = (1 << COUNT_SHIFT) - 1
MM_PER_M = 1000.0


class PixelCounter:
    """Counts and summed distances per cell, for one camera; the arrays are made once for an image size and overwritten.

    grid: (TANGENT_BINS * cells,) number of pixels * 2^40 + sum of their level forward distances in mm.
    is_cut: (TANGENT_BINS * cells,) whether one of them lies at the edge of the picture: what it belongs to may go on outside.
    """

    def __init__(self, parameters: PerceptionParameters, cells: DistanceCells, range_min_m: float, range_max_m: float) -> None:
        self._stride = parameters.stride_px
        self._first = max(1, self._stride // 2)
        self._noise = parameters.depth_noise_1_m
        self._range_m = (range_min_m, range_max_m)
        self._cells = cells
        self._intrinsics: Intrinsics | None = None
        self.grid: NDArray[np.int64] = np.zeros(TANGENT_BINS * len(cells), np.int64)
        self.is_cut: NDArray[np.bool_] = np.zeros(TANGENT_BINS * len(cells), np.bool_)

    def count(self, frame: DepthFrame, camera: CameraPose, band: HeightBand) -> None:
        """Fill the grid from one frame, whose depth is (height, width) uint16 in C order."""
        k = frame.intrinsics
        if k != self._intrinsics:
            self._prepare(k)
        limits = (band.top_m, band.bottom_m, band.slope, band.ground_m, band.ground_slope)
        _count_pixels(
            frame.depth,
            frame.depth_unit_m,
            self._first,
            self._stride,
            self._x,
            self._y,
            camera.level.astype(np.float32),
            np.array(limits, np.float32),
            *self._range_m,
            self._noise,
            self._cells.cell_of,
            len(self._cells),
            self._raw,
            self._is_used,
            self._ahead,
            self._bearing,
            self.grid,
            self.is_cut,
        )

    def _prepare(self, k: Intrinsics) -> None:
        # The outermost pixels have no neighbour on one side and are not used.
        self._x = ((np.arange(self._first, k.width_px - 1, self._stride) - k.cx_px) / k.fx_px).astype(np.float32)
        self._y = ((np.arange(self._first, k.height_px - 1, self._stride) - k.cy_px) / k.fy_px).astype(np.float32)
        self._raw = np.zeros(len(self._x), np.int32)
        self._is_used = np.zeros(len(self._x), np.bool_)
        self._ahead = np.zeros(len(self._x), np.float32)
        self._bearing = np.zeros(len(self._x), np.int32)
        self._intrinsics = k


@njit(
    "void(u2[:,::1],f8,i8,i8,f4[::1],f4[::1],f4[:,::1],f4[::1],f8,f8,f8,i4[::1],i8,i4[::1],b1[::1],f4[::1],i4[::1],i8[::1],b1[::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _count_pixels(  # type: ignore[no-untyped-def]
    depth,
    unit_m,
    first,
    stride,
    x,
    y,
    level,
    limits,
    range_min,
    range_max,
    noise,
    cell_of,
    cells,
    raws,
    used,
    ahead,
    bearing,
    grid,
    is_cut,
):  # fmt: skip
    """depth: (height, width). x, y: normalised image coordinates of the used columns and rows. limits: of the height band.

    raws, used, ahead, bearing: work space for one row. The loops over it have no branch, so that they become vector instructions.
    """
    grid[:] = 0
    is_cut[:] = False
    unit = np.float32(unit_m)
    lowest = np.int32(max(1.0, math.ceil(range_min / unit_m)))
    highest = np.int32(min(65534.0, math.floor(range_max / unit_m)))
    dense = np.int32(min(65535.0, _DENSE_M / unit_m))
    half_dense = np.int32(min(65535.0, 0.5 * _DENSE_M / unit_m))
    top, bottom, slope, ground, ground_slope = limits[0], limits[1], limits[2], limits[3], limits[4]
    alike_per_raw2, alike_min = np.float32(_ALIKE_SIGMAS * noise * unit_m), np.float32(_ALIKE_M / unit_m)
    alike_pixels_min = np.int32(_ALIKE_PIXELS_MIN)
    tangent_max, bins_per_tangent = np.float32(TANGENT_MAX), np.float32(1.0 / TANGENT_STEP)
    forward_min, last_bin = np.float32(_FORWARD_MIN_M), np.int32(TANGENT_BINS - 1)
    steps_per_m, mm_per_m = np.float32(1.0 / TABLE_STEP_M), np.float32(MM_PER_M)
    furthest, columns, rows = cell_of.shape[0] - 1, x.shape[0], y.shape[0]
    for j in range(rows):
        v = first + j * stride
        row, above, below = depth[v, first::stride], depth[v - 1, first::stride], depth[v + 1, first::stride]
        before, after = depth[v, first - 1 :: stride], depth[v, first + 1 :: stride]
        for i in range(columns):
            raws[i] = row[i]
        # Nearer than this, this row is one of those left out.
        nearest = max(lowest, dense if j % 2 == 1 else (half_dense if j % 4 == 2 else np.int32(0)))
        per_x, down_row = level[2, 0], level[2, 1] * y[j] + level[2, 2]
        total = np.int32(0)
        for i in range(columns):
            raw = raws[i]
            z = np.float32(raw) * unit
            down = z * (per_x * x[i] + down_row)
            widened = z * slope
            in_range = (raw >= nearest) & (raw <= highest)
            in_band = (down >= top - widened) & (down <= bottom + widened) & (down + z * ground_slope <= ground)
            used[i] = in_range & in_band
            total += np.int32(used[i])
        if total == 0:
            continue
        for i in range(columns):
            raw = raws[i]
            alike = np.int32(alike_min + alike_per_raw2 * np.float32(raw) * np.float32(raw))
            number = np.int32(abs(np.int32(above[i]) - raw) <= alike) + np.int32(abs(np.int32(below[i]) - raw) <= alike)
            number += np.int32(abs(np.int32(before[i]) - raw) <= alike) + np.int32(abs(np.int32(after[i]) - raw) <= alike)
            used[i] = used[i] & (number >= alike_pixels_min)
        ahead_row, aside_row = level[0, 1] * y[j] + level[0, 2], level[1, 1] * y[j] + level[1, 2]
        ahead_per_x, aside_per_x = level[0, 0], level[1, 0]
        for i in range(columns):
            ahead[i] = ahead_per_x * x[i] + ahead_row
            tangent = (aside_per_x * x[i] + aside_row) / ahead[i]
            used[i] = used[i] & (abs(tangent) < tangent_max) & (ahead[i] * np.float32(raws[i]) * unit > forward_min)
            bounded = min(max(tangent, -tangent_max), tangent_max)
            bearing[i] = np.int32((bounded + tangent_max) * bins_per_tangent)
        is_edge_row = j < _EDGE_ROWS or j >= rows - _EDGE_ROWS
        for i in range(columns):
            if not used[i]:
                continue
            raw = raws[i]
            forward = ahead[i] * np.float32(raw) * unit
            cell = min(bearing[i], last_bin) * cells + cell_of[min(np.int32(forward * steps_per_m), furthest)]
            weight = 4 if raw < half_dense else (2 if raw < dense else 1)
            grid[cell] += np.int64(weight) * ((np.int64(1) << COUNT_SHIFT) + np.int64(forward * mm_per_m + np.float32(0.5)))
            if is_edge_row or i == 0 or i == columns - 1:
                is_cut[cell] = True
