"""From the polar grid to points on surfaces: what is too small to be real is dropped, what noise spread over cells is joined."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.extraction.pixels import COUNT_SHIFT, MM_PER_M, SUM_MASK
from perception.extraction.polar_grid import DistanceCells
from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.parameters import PerceptionParameters
from perception.types import Intrinsics

_SPREAD_FRACTION = 0.25
"""Fraction of a surface's pixels that may be left in one cell when noise spreads it over several."""
_NOISE_TAIL_FRACTION = 0.25
_LIMIT_SIGMAS = 3.0
_LIMIT_FRACTION = 0.25
"""Within 3 sigma of the range limit a surface must fill this much of the height band: noise brings tails of what is beyond."""
_FACE_ON_SIGMAS = 1.5
"""Pixels of one bearing bin that scatter by less than this are one surface; noise alone scatters them by one."""
_BESIDE_BINS = 2
_THIN_FRACTION = 0.35
_THIN_PIXELS_MIN = 8.0
"""A level thing as high as `thin_height_min_m` must show a third of its pixels in five neighbouring bearing bins."""
_CUT_AREA_FRACTION = 0.1
"""Of the smallest visible area, a surface at the edge of the picture needs this much."""
_WEAK, _COUNTED = -1, -2
"""In place of a parent: pixels that are no place of a surface, but may count for one; nothing, or counted already."""


@dataclass(frozen=True, slots=True)
class SurfacePoints:
    """Points on visible surfaces in the level frame, sorted by surface, then by bearing; views of buffers, good for one frame.

    forward_m, right_m: (n,). half_depth_m: (n,), 0 where one point stands for a surface seen face on, half the cell's depth
    where a surface runs along the line of sight. bin: (n,) bearing bin. starts: (surfaces + 1,) index of each surface's first
    point. evidence: (surfaces,) how many times over the surface has the pixels it needs.
    nearest_m: (TANGENT_BINS,) forward distance of the first surface in each bearing bin, inf where there is none.
    is_excluded: (TANGENT_BINS,) bearing bins in which something was left out on demand.
    """

    forward_m: NDArray[np.float64]
    right_m: NDArray[np.float64]
    half_depth_m: NDArray[np.float64]
    bin: NDArray[np.int32]
    starts: NDArray[np.int32]
    evidence: NDArray[np.float64]
    nearest_m: NDArray[np.float64]
    is_excluded: NDArray[np.bool_]


class SurfaceFinder:
    """Finds surfaces in the grid of one camera; holds all buffers."""

    def __init__(self, parameters: PerceptionParameters, cells: DistanceCells, range_max_m: float) -> None:
        self._parameters = parameters
        self._cells = cells
        self._range_max_m = range_max_m
        self.reliable_range_m = range_max_m - _LIMIT_SIGMAS * parameters.depth_noise_1_m * range_max_m**2
        """Depth up to which anything of the smallest visible size is found."""
        size = TANGENT_BINS * len(cells)
        self._counts = np.zeros(size, np.int32)
        self._forward = np.zeros(size)
        self._parent = np.zeros(size, np.int32)
        self._lists = np.zeros((4, size), np.int32)
        self._tallies = np.zeros((4, size))
        self._points = np.zeros((3, size))
        self._bin = np.zeros(size, np.int32)
        self._starts = np.zeros(size + 1, np.int32)
        self._evidence = np.zeros(size)
        self._nearest_m = np.zeros(TANGENT_BINS)
        self._is_excluded = np.zeros(TANGENT_BINS, np.bool_)
        self._intrinsics: Intrinsics | None = None

    def find(
        self,
        grid: NDArray[np.int64],
        is_cut: NDArray[np.bool_],
        intrinsics: Intrinsics,
        camera: CameraPose,
        exclude: NDArray[np.float64],
    ) -> SurfacePoints:
        """Surfaces without what lies inside `exclude` (k, 3: north, east, radius). grid, is_cut: see `PixelCounter`."""
        if intrinsics != self._intrinsics:
            self._prepare(intrinsics)
        parameters = self._parameters
        points, surfaces = _find_surfaces(
            grid,
            is_cut,
            self._cells.edges_m,
            self._needed,
            self._bridge_bins,
            self._pixels_per_m2_at_1_m,
            parameters.depth_noise_1_m,
            parameters.cell_m,
            parameters.visible_area_min_m2,
            parameters.pixels_min,
            float(camera.level[0, 2]),
            self.reliable_range_m,
            self._range_max_m,
            _in_level_frame(exclude, camera),
            self._counts,
            self._forward,
            self._parent,
            self._lists,
            self._tallies,
            self._points,
            self._bin,
            self._starts,
            self._evidence,
            self._nearest_m,
            self._is_excluded,
        )
        return SurfacePoints(
            self._points[0, :points],
            self._points[1, :points],
            self._points[2, :points],
            self._bin[:points],
            self._starts[: surfaces + 1],
            self._evidence[:surfaces],
            self._nearest_m,
            self._is_excluded,
        )

    def _prepare(self, intrinsics: Intrinsics) -> None:
        """Pixels that a cell needs: of the smallest visible height over one bin, of a thin thing over several, at the limit."""
        parameters = self._parameters
        stride = parameters.stride_px
        self._intrinsics = intrinsics
        self._pixels_per_m2_at_1_m = intrinsics.fx_px * intrinsics.fy_px / stride**2
        self._bridge_bins = 1 + math.ceil(stride / (intrinsics.fx_px * TANGENT_STEP))
        distance = np.maximum(self._cells.edges_m, parameters.cell_m).astype(np.float64)
        per_height = TANGENT_STEP / distance * self._pixels_per_m2_at_1_m
        tall = np.maximum(2.0, _SPREAD_FRACTION * per_height * parameters.visible_height_min_m)
        thin = np.maximum(_THIN_PIXELS_MIN, _THIN_FRACTION * (2 * _BESIDE_BINS + 1) * per_height * parameters.thin_height_min_m)
        limit = np.maximum(tall, np.maximum(2.0, _LIMIT_FRACTION * per_height * 2 * parameters.band_m))
        self._needed = np.stack([tall, thin, limit])


def _in_level_frame(exclude: NDArray[np.float64], camera: CameraPose) -> NDArray[np.float64]:
    """(k, 3) forward, right, radius."""
    cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
    north, east = exclude[:, 0] - camera.position_ned_m[0], exclude[:, 1] - camera.position_ned_m[1]
    return np.column_stack([north * cos + east * sin, east * cos - north * sin, exclude[:, 2]])


@njit("i4(i4[::1],i4)", cache=True, nogil=True, error_model="numpy")
def _root(parent, i):  # type: ignore[no-untyped-def]
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit("b1(f8,f8,f8,f8[:,::1])", cache=True, nogil=True, error_model="numpy")
def _is_inside(forward, right, noise, circles):  # type: ignore[no-untyped-def]
    """Whether a point lies inside a circle (forward, right, radius) stretched along the line of sight by the depth noise."""
    for k in range(circles.shape[0]):
        ahead, aside, radius = circles[k, 0], circles[k, 1], circles[k, 2]
        distance = max(math.sqrt(ahead * ahead + aside * aside), 1e-6)
        along = (forward * ahead + right * aside) / distance - distance
        across = (right * ahead - forward * aside) / distance
        stretched = radius + 2.0 * noise * distance * distance
        if (along / stretched) ** 2 + (across / radius) ** 2 <= 1.0:
            return True
    return False


@njit(
    "UniTuple(i8,2)(i4[::1],b1[::1],f4[::1],f8,f8,f8,f8,i8,i4[::1],f8[::1],i4[::1],i4[::1],i4[::1],f8[:,::1],f8[:,::1],"
    "i4[::1],i4[::1],f8[::1],f8[::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _collect(  # type: ignore[no-untyped-def]
    strong,
    is_cut,
    edges,
    pixels_per_m2,
    noise,
    cell_m,
    area_min,
    pixels_min,
    counts,
    forwards,
    parent,
    label,
    role,
    tallies,
    points,
    bins,
    starts,
    evidence,
    nearest,
):
    """Points on the surfaces that are large enough, face-on runs of cells merged into one point, sorted by surface."""
    cells = edges.shape[0]
    area, number, mean, needed_area = tallies[0], tallies[1], tallies[2], tallies[3]
    for k in range(strong.shape[0]):
        cell = strong[k]
        root = _root(parent, cell)
        # A root is the first cell of its surface.
        if cell == root:
            area[root] = number[root] = 0.0
            needed_area[root] = area_min
        # What the picture cuts off may go on outside.
        if is_cut[cell]:
            needed_area[root] = _CUT_AREA_FRACTION * area_min
        b, c = cell // cells, cell % cells
        for beside in range(max(b - 1, 0), min(b + 1, TANGENT_BINS - 1) + 1):
            for near in range(max(c - 1, 0), min(c + 1, cells - 2) + 1):
                other = beside * cells + near
                # Too few to be a place of the surface, but its pixels all the same; counted once.
                if other == cell or parent[other] == _WEAK:
                    area[root] += counts[other] * forwards[other] ** 2 / pixels_per_m2
                    number[root] += counts[other]
                    if other != cell:
                        parent[other] = _COUNTED
    surfaces = 0
    for k in range(strong.shape[0]):
        cell = strong[k]
        if cell == _root(parent, cell):
            is_real = area[cell] >= needed_area[cell] and number[cell] >= pixels_min
            label[cell] = surfaces if is_real else -1
            if is_real:
                evidence[surfaces] = min(area[cell] / needed_area[cell], number[cell] / pixels_min)
                starts[surfaces] = 0
                surfaces += 1
    starts[surfaces] = 0
    k = 0
    while k < strong.shape[0]:
        end = k + 1
        while end < strong.shape[0] and strong[end] == strong[end - 1] + 1:
            end += 1
        mine = label[_root(parent, strong[k])]
        if mine < 0:
            for i in range(k, end):
                role[i] = 0
            k = end
            continue
        b = strong[k] // cells
        nearest[b] = min(nearest[b], forwards[strong[k]])
        weighted = squared = pixels = 0.0
        for i in range(k, end):
            weighted += counts[strong[i]] * forwards[strong[i]]
            squared += counts[strong[i]] * forwards[strong[i]] ** 2
            pixels += counts[strong[i]]
        mean[k] = weighted / pixels
        spread = math.sqrt(max(squared / pixels - mean[k] ** 2, 0.0))
        face_on = spread <= _FACE_ON_SIGMAS * noise * mean[k] ** 2 + cell_m / 2
        for i in range(k, end):
            role[i] = (1 if i == k else 0) if face_on else 2
            starts[mine + 1] += 1 if role[i] else 0
        k = end
    for surface in range(surfaces):
        starts[surface + 1] += starts[surface]
    for k in range(strong.shape[0]):
        if role[k] == 0:
            continue
        cell = strong[k]
        mine = label[_root(parent, cell)]
        # While the points are written, starts[surface] runs ahead; it is set back below.
        at = starts[mine]
        starts[mine] += 1
        b, c = cell // cells, cell % cells
        forward = mean[k] if role[k] == 1 else forwards[cell]
        points[0, at] = forward
        points[1, at] = forward * ((b + 0.5) * TANGENT_STEP - TANGENT_MAX)
        points[2, at] = 0.0 if role[k] == 1 else (edges[c + 1] - edges[c]) / 2
        bins[at] = b
    for surface in range(surfaces, 0, -1):
        starts[surface] = starts[surface - 1]
    starts[0] = 0
    return starts[surfaces], surfaces


@njit(
    "UniTuple(i8,2)(i8[::1],b1[::1],f4[::1],f8[:,::1],i8,f8,f8,f8,f8,i8,f8,f8,f8,f8[:,::1],"
    "i4[::1],f8[::1],i4[::1],i4[:,::1],f8[:,::1],f8[:,::1],i4[::1],i4[::1],f8[::1],f8[::1],b1[::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _find_surfaces(  # type: ignore[no-untyped-def]
    grid,
    is_cut,
    edges,
    needed,
    bridge,
    pixels_per_m2,
    noise,
    cell_m,
    area_min,
    pixels_min,
    along_axis,
    reliable_range,
    range_max,
    exclude,
    counts,
    forwards,
    parent,
    lists,
    tallies,
    points,
    bins,
    starts,
    evidence,
    nearest,
    is_excluded,
):
    """Returns how many points and surfaces there are. Depth limits apply along the optical axis, tilted by acos(along_axis)."""
    cells = edges.shape[0]
    occupied, strong = lists[0], lists[1]
    total = 0
    for cell in range(grid.shape[0]):
        parent[cell] = _COUNTED
        packed = grid[cell]
        counts[cell] = 0
        if packed != 0 and cell % cells != cells - 1:
            counts[cell] = np.int32(packed >> COUNT_SHIFT)
            forwards[cell] = (packed & SUM_MASK) / MM_PER_M / counts[cell]
            parent[cell] = _WEAK
            occupied[total] = cell
            total += 1
    nearest[:] = np.inf
    is_excluded[:] = False
    found, tall_bin = 0, -1
    for k in range(total):
        cell = occupied[k]
        b, c = cell // cells, cell % cells
        number, forward = counts[cell], forwards[cell]
        around = max(counts[cell - 1] if c > 0 else 0, counts[cell + 1])
        depth = forward * along_axis
        if number < _NOISE_TAIL_FRACTION * around or depth > range_max - noise * depth * depth:
            continue
        if edges[c + 1] * along_axis > reliable_range:
            if number < needed[2, c]:
                continue
        elif number >= needed[0, c]:
            tall_bin = b
        elif b == tall_bin:
            # Behind something tall in the same bearing this is its top, or of no matter.
            continue
        else:
            support = most = 0
            for beside in range(max(b - _BESIDE_BINS, 0), min(b + _BESIDE_BINS, TANGENT_BINS - 1) + 1):
                for near in range(max(c - 1, 0), min(c + 1, cells - 1) + 1):
                    support += counts[beside * cells + near]
                    most = max(most, counts[beside * cells + near])
            # Beside a wall or a tree, support is no proof: what noise scatters around it is left out.
            if support < needed[1, c] or number < _NOISE_TAIL_FRACTION * most:
                continue
        right = forward * ((b + 0.5) * TANGENT_STEP - TANGENT_MAX)
        if _is_inside(forward, right, noise, exclude):
            is_excluded[b] = True
            parent[cell] = _COUNTED
            nearest[b] = min(nearest[b], forward)
            continue
        parent[cell] = cell
        strong[found] = cell
        found += 1
        # Bearing bins without a pixel, because of the stride or a hole, do not part a surface.
        for back in range(min(bridge, b) + 1):
            for near in range(max(c - 1, 0), min(c + 1, cells - 1) + 1 if back else c):
                other = (b - back) * cells + near
                if parent[other] >= 0:
                    one, two = _root(parent, np.int32(cell)), _root(parent, np.int32(other))
                    if one != two:
                        parent[max(one, two)] = min(one, two)
    return _collect(
        strong[:found],
        is_cut,
        edges,
        pixels_per_m2,
        noise,
        cell_m,
        area_min,
        pixels_min,
        counts,
        forwards,
        parent,
        lists[2],
        lists[3],
        tallies,
        points,
        bins,
        starts,
        evidence,
        nearest,
    )
