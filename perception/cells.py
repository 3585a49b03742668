"""From depth pixels to surface points: a polar grid in the level frame of the camera.

One axis of the grid is the tangent of the bearing (as image columns are), the other the distance forward, in cells that grow
with the depth noise. Sorting pixels into it costs two passes over the pixels inside the height band and nothing else; walls,
poles and noise then are a matter of a few hundred cells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP, TANGENTS
from perception.geometry import CameraPose
from perception.parameters import PerceptionParameters
from perception.types import Intrinsics

_FORWARD_MIN_M = 0.05
_CELL_SIGMAS = 2.5
_TABLE_STEP_M = 0.01
_BRIDGE = np.ones((3, 1), np.uint8)
"""Bearing bins without a pixel, because of the stride or a hole, do not part a surface."""
_SLANT = 1.6
"""Level forward distance of a pixel is at most this times its depth for any attitude in which perception is of use."""
_NOISE_TAIL_FRACTION = 0.25
_PIXELS_MAX = 40000
"""With more pixels than this in the band (something large is near) rows are left out; the others count for them."""
_LIMIT_SIGMAS = 3.0
_LIMIT_FRACTION = 0.25
"""Within 3 sigma of the range limit a surface must fill this much of the height band: noise brings tails of what is beyond."""
_SPREAD_FRACTION = 0.25
"""Fraction of a surface's pixels that may be left in one cell when noise spreads it over several."""


@dataclass(frozen=True, slots=True)
class SurfacePoints:
    """Points on visible surfaces in the level frame, sorted by label, then by bearing.

    forward_m, right_m: (n,). half_depth_m: (n,), 0 where one point stands for a surface seen face on, half the cell's depth
    where a surface runs along the line of sight. bin: (n,) bearing bin. label: (n,) connected surface.
    nearest_m: (TANGENT_BINS,) forward distance of the first surface in each bearing bin, inf where there is none.
    """

    forward_m: NDArray[np.float64]
    right_m: NDArray[np.float64]
    half_depth_m: NDArray[np.float64]
    bin: NDArray[np.intp]
    label: NDArray[np.intp]
    nearest_m: NDArray[np.float64]


class CellGrid:
    """Holds the grid's tables and the pixel buffers for one image size; `points` may be called once a frame, from one thread."""

    def __init__(self, parameters: PerceptionParameters, range_min_m: float, range_max_m: float) -> None:
        self._parameters = parameters
        self._range_min_m = np.float32(range_min_m)
        self._range_max_m = np.float32(range_max_m)
        self.reliable_range_m = range_max_m - _LIMIT_SIGMAS * parameters.depth_noise_1_m * range_max_m**2
        """Depth up to which anything of the smallest visible size is found."""
        edges = [0.0]
        while edges[-1] < _SLANT * range_max_m:
            sigma = parameters.depth_noise_1_m * edges[-1] ** 2
            edges.append(edges[-1] + max(parameters.cell_m, _CELL_SIGMAS * sigma))
        self._edges = np.array(edges)
        # One spare cell at the far end keeps neighbours in the flat array neighbours in space.
        self._cells = len(edges)
        centres = np.arange(int(edges[-1] / _TABLE_STEP_M)) * _TABLE_STEP_M + _TABLE_STEP_M / 2
        self._cell_of = (np.searchsorted(self._edges, centres, side="right") - 1).astype(np.int32)
        self._intrinsics: Intrinsics | None = None

    def sigma_m(self, forward_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Standard deviation of the depth noise at a distance."""
        return self._parameters.depth_noise_1_m * forward_m**2

    def points(
        self,
        depth: NDArray[np.uint16],
        depth_unit_m: float,
        intrinsics: Intrinsics,
        camera: CameraPose,
        vehicle_down_m: float,
        ground_down_m: float | None,
        exclude: NDArray[np.float64],
    ) -> SurfacePoints:
        """Surfaces in the height band, without the ground and without what lies inside `exclude` (k, 3: north, east, radius)."""
        if intrinsics != self._intrinsics:
            self._prepare(intrinsics)
        cell, forward, thin = self._bin_pixels(depth, depth_unit_m, camera, vehicle_down_m, ground_down_m)
        size = TANGENT_BINS * self._cells
        counts: NDArray[np.intp] = np.bincount(cell, minlength=size)
        sums = np.asarray(np.bincount(cell, weights=forward, minlength=size), np.float64)
        if thin > 1:
            counts *= thin
            sums *= thin
        return self._surfaces(counts, sums, camera, exclude)

    def _prepare(self, intrinsics: Intrinsics) -> None:
        stride = self._parameters.stride_px
        self._intrinsics = intrinsics
        first = stride // 2
        self._x = ((np.arange(first, intrinsics.width_px, stride) - intrinsics.cx_px) / intrinsics.fx_px).astype(np.float32)
        self._y = ((np.arange(first, intrinsics.height_px, stride) - intrinsics.cy_px) / intrinsics.fy_px).astype(np.float32)
        shape = (len(self._y), len(self._x))
        self._z = np.zeros(shape, np.float32)
        self._work = np.zeros(shape, np.float32)
        self._mask = np.zeros(shape, np.bool_)
        self._more = np.zeros(shape, np.bool_)
        # Pixels a cell must hold: those of the smallest visible height over one bearing bin, less what noise spreads elsewhere.
        self._pixels_per_m2_at_1_m = intrinsics.fx_px * intrinsics.fy_px / stride**2
        distance = np.maximum(self._edges, self._parameters.cell_m)
        area_1_m = TANGENT_STEP * self._parameters.visible_height_min_m / distance
        self._cell_pixels_min = np.maximum(2.0, _SPREAD_FRACTION * area_1_m * self._pixels_per_m2_at_1_m).astype(np.float32)
        area_1_m = TANGENT_STEP * 2 * self._parameters.band_m / distance
        self._limit_pixels_min = np.maximum(2.0, _LIMIT_FRACTION * area_1_m * self._pixels_per_m2_at_1_m).astype(np.float32)

    def _bin_pixels(
        self,
        depth: NDArray[np.uint16],
        depth_unit_m: float,
        camera: CameraPose,
        vehicle_down_m: float,
        ground_down_m: float | None,
    ) -> tuple[NDArray[np.int32], NDArray[np.float32], int]:
        """Cell number and level forward distance of the pixels in the band; every how many rows of them were used."""
        parameters = self._parameters
        stride = parameters.stride_px
        z, work, mask, more = self._z, self._work, self._mask, self._more
        first = stride // 2
        np.multiply(depth[first::stride, first::stride], np.float32(depth_unit_m), out=z)
        level = camera.level.astype(np.float32)
        camera_down_m = float(camera.position_ned_m[2])
        top = np.float32(vehicle_down_m - parameters.band_m - camera_down_m)
        bottom = np.float32(vehicle_down_m + parameters.band_m - camera_down_m)
        np.add(level[2, 0] * self._x, (level[2, 1] * self._y + level[2, 2])[:, None], out=work)
        np.multiply(work, z, out=work)
        np.greater_equal(work, top, out=mask)
        mask &= np.less_equal(work, bottom, out=more)
        mask &= np.greater_equal(z, self._range_min_m, out=more)
        mask &= np.less_equal(z, self._range_max_m, out=more)
        if ground_down_m is not None:
            ground = np.float32(ground_down_m - parameters.ground_margin_m - camera_down_m)
            slope = np.float32(parameters.ground_margin_slope)
            if ground - slope * self._range_max_m < bottom:
                work += slope * z
                mask &= np.less_equal(work, ground, out=more)
        thin = max(1, math.ceil(int(np.count_nonzero(mask)) / _PIXELS_MAX))
        index = np.flatnonzero(mask[::thin])
        row, column = np.divmod(index.astype(np.int32), np.int32(len(self._x)))
        row *= np.int32(thin)
        x, y = self._x[column], self._y[row]
        ahead = level[0, 0] * x + level[0, 1] * y + level[0, 2]
        tangent = (level[1, 0] * x + level[1, 1] * y + level[1, 2]) / np.maximum(ahead, np.float32(1e-3))
        forward = ahead * z[row, column]
        inside = (forward > _FORWARD_MIN_M) & (np.abs(tangent) < TANGENT_MAX)
        if not inside.all():
            tangent, forward = tangent[inside], forward[inside]
        far = np.int32(len(self._cell_of) - 1)
        nth = np.minimum((forward * np.float32(1 / _TABLE_STEP_M)).astype(np.int32), far)
        bearing = ((tangent + np.float32(TANGENT_MAX)) * np.float32(1 / TANGENT_STEP)).astype(np.int32)
        return bearing * np.int32(self._cells) + self._cell_of[nth], forward, thin

    def _surfaces(
        self,
        counts: NDArray[np.intp],
        sums: NDArray[np.float64],
        camera: CameraPose,
        exclude: NDArray[np.float64],
    ) -> SurfacePoints:
        grid = counts.reshape(TANGENT_BINS, self._cells).astype(np.float32)
        around = cv2.dilate(grid, np.ones((1, 3), np.uint8))
        # Depth limits apply along the optical axis: at a tilt they lie further forward.
        along_axis = float(camera.level[0, 2])
        near_limit = np.append(self._edges[1:], np.inf) * along_axis > self.reliable_range_m
        wanted = np.where(near_limit, np.maximum(self._limit_pixels_min, self._cell_pixels_min), self._cell_pixels_min)
        strong = (grid >= wanted) & (grid >= np.float32(_NOISE_TAIL_FRACTION) * around)
        strong[:, -1] = False
        flat = np.flatnonzero(strong)
        nearest_m = np.full(TANGENT_BINS, np.inf)
        if not flat.size:
            nothing = np.zeros(0)
            none = np.zeros(0, np.intp)
            return SurfacePoints(nothing, nothing, nothing, none, none, nearest_m)
        pixels = counts[flat]
        forward = sums[flat] / pixels
        bin_ = flat // self._cells
        reliable = forward * along_axis <= self._range_max_m - self.sigma_m(forward * along_axis)
        if not reliable.all():
            strong.ravel()[flat[~reliable]] = False
            flat, pixels, forward, bin_ = flat[reliable], pixels[reliable], forward[reliable], bin_[reliable]
        firsts = np.flatnonzero(np.diff(bin_, prepend=-1))
        nearest_m[bin_[firsts]] = forward[firsts]
        if len(exclude):
            keep = ~self._excluded(forward, forward * TANGENTS[bin_], camera, exclude)
            strong.ravel()[flat[~keep]] = False
            flat, pixels, forward, bin_ = flat[keep], pixels[keep], forward[keep], bin_[keep]
        return self._merge(strong, flat, pixels, forward, bin_, nearest_m)

    def _excluded(
        self,
        forward: NDArray[np.float64],
        right: NDArray[np.float64],
        camera: CameraPose,
        exclude: NDArray[np.float64],
    ) -> NDArray[np.bool_]:
        """Which cells lie inside an exclusion circle, stretched along the line of sight by the depth noise."""
        cos, sin = np.cos(camera.heading_rad), np.sin(camera.heading_rad)
        north, east = exclude[:, 0] - camera.position_ned_m[0], exclude[:, 1] - camera.position_ned_m[1]
        ahead, aside, radius = north * cos + east * sin, east * cos - north * sin, exclude[:, 2]
        distance = np.maximum(np.hypot(ahead, aside), 1e-6)
        along = (forward[:, None] * ahead + right[:, None] * aside) / distance - distance
        across = (right[:, None] * ahead - forward[:, None] * aside) / distance
        stretched = radius + 2 * self.sigma_m(distance)
        inside: NDArray[np.bool_] = ((along / stretched) ** 2 + (across / radius) ** 2 <= 1.0).any(axis=1)
        return inside

    def _merge(
        self,
        strong: NDArray[np.bool_],
        flat: NDArray[np.intp],
        pixels: NDArray[np.intp],
        forward: NDArray[np.float64],
        bin_: NDArray[np.intp],
        nearest_m: NDArray[np.float64],
    ) -> SurfacePoints:
        """Drop connected surfaces that are too small to be real; join cells over which noise has spread one surface."""
        parameters = self._parameters
        closed = cv2.morphologyEx(strong.astype(np.uint8), cv2.MORPH_CLOSE, _BRIDGE)
        total, labels = cv2.connectedComponents(closed, connectivity=8)
        label = labels.ravel()[flat]
        area = np.bincount(label, pixels * forward**2, total) / self._pixels_per_m2_at_1_m
        number = np.bincount(label, pixels, total)
        kept = ((area >= parameters.visible_area_min_m2) & (number >= parameters.pixels_min))[label]
        flat, pixels, forward, bin_, label = flat[kept], pixels[kept], forward[kept], bin_[kept], label[kept]
        starts = np.flatnonzero(np.diff(flat, prepend=-2) != 1)
        if not starts.size:
            nothing = np.zeros(0)
            return SurfacePoints(nothing, nothing, nothing, flat, flat, nearest_m)
        ends = np.append(starts[1:], len(flat)) - 1
        spread = forward[ends] - forward[starts]
        mean = np.add.reduceat(pixels * forward, starts) / np.add.reduceat(pixels, starts)
        face_on = spread <= _CELL_SIGMAS * self.sigma_m(mean) + parameters.cell_m
        run = np.repeat(np.arange(len(starts)), ends - starts + 1)
        along_sight = ~face_on[run]
        cells = flat[along_sight] % self._cells
        half_depth = np.concatenate([np.zeros(int(face_on.sum())), (self._edges[cells + 1] - self._edges[cells]) / 2])
        distance = np.concatenate([mean[face_on], forward[along_sight]])
        bins = np.concatenate([bin_[starts[face_on]], bin_[along_sight]])
        surface = np.concatenate([label[starts[face_on]], label[along_sight]]).astype(np.intp)
        order = np.lexsort((distance, bins, surface))
        distance, bins = distance[order], bins[order]
        return SurfacePoints(distance, distance * TANGENTS[bins], half_depth[order], bins, surface[order], nearest_m)
