"""Where the frame proves anything: no return is no evidence of free space unless something else tells that the camera sees.

A depth camera returns nothing from the open sky, from behind a finger and out of the glare of the sun. What counts as seen is
decided by bearing, for three bearing bins (two degrees) at a time:

- At least one pixel in two hundred of the whole column, from the top to the bottom of the picture, must return a distance up to
  30 m: the ground, a tree, the noisy distance. A few returns are enough where they lie at the distance of the ground. A column
  without any return proves nothing and is unseen.
- Where the ground is due within range, a fifth of the pixels must return, the ground or what stands before it.
- Where the furthest ground that other bearings show does not return, something hides it (extraction/ground_strip.py).
- Where one pixel in ten is nearer than the camera can measure, something is in front of the lens.
- A hole, a region without returns that is enclosed by returns or by the picture's edge other than towards the sky, hides the
  bearings in which it reaches into the height band. A gap between trees that is open to the sky is no hole.

Nothing can return from beneath the ground. If a large share does, picture, mounting, height or lens data do not fit together,
and nothing at all is believed. A slope down of one in ten, and half as much again in height, are still taken for terrain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import SECTORS, TANGENT_BINS, TANGENT_MAX, TANGENT_STEP, bins_of_sectors
from perception.extraction.ground_strip import GroundStripSurvey
from perception.extraction.height_band import HeightBand
from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.parameters import PerceptionParameters
from perception.types import DepthFrame, Intrinsics

_REAL_MAX_M = 30.0
"""A D435 returns noisy but true distances up to about here."""
_STEP_MAX_PX = 4
_TILE_STEPS = 4
_GROUND_RANGE_FRACTION = 0.95
_FAR_GROUND_MAX_M = 25.0
_DUE_MIN = 16
_RETURNED_MIN = 4
_NEAR_FRACTION_MAX = 0.1
_COVERED_FRACTION = 0.5
_HOLE_TILES_MIN = 9
_HOLE_RETURNS_MAX = 0.1
_HOLE_DISTANCE_M = 3.0
_SKYWARD = 0.3
_TERRAIN_HEIGHT = 1.5
_TERRAIN_SLOPE = 0.1
_CONTRADICTION_FRACTION = 0.3
REACH_STEP_M = 0.25
_REACH_RETURNS_MIN = 3
_REACH_FRACTION = 0.1
_BELOW_M = 0.5
_WANTED, _RETURNED, _NEAR, _DUE, _DUE_RETURNED, _FAR_DUE, _BELOW = range(7)
_TALLIES = 7
_SATURATED = 65535


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a frame proves.

    hidden: (360,) half-degree sectors ahead of which it proves nothing. is_blind: (360,) those among them in which something
    should have returned, or is too near; in the others nothing may be within reach, as above the horizon.
    furthest_m: (TANGENT_BINS,), see `View`. standing: (TANGENT_BINS, reaches) samples within the height band that returned, by
    their forward distance in steps of `REACH_STEP_M`. below, below_m: (TANGENT_BINS,) samples that show something which stands
    less than half a metre below the height band, and the forward distance of the nearest.
    fault: what makes the whole frame unusable, or nothing. The other fields are then of no use.
    """

    hidden: NDArray[np.bool_]
    is_blind: NDArray[np.bool_]
    furthest_m: NDArray[np.float64]
    standing: NDArray[np.int32]
    below: NDArray[np.int32]
    below_m: NDArray[np.float64]
    fault: str = ""


class EvidenceSurvey:
    """Looks at every fourth row and column of a whole frame; holds all buffers, which the next frame overwrites."""

    def __init__(self, parameters: PerceptionParameters, range_min_m: float, range_max_m: float, reliable_range_m: float) -> None:
        self._parameters = parameters
        self._range_min_m = range_min_m
        self._range_max_m = range_max_m
        self._reliable_range_m = reliable_range_m
        self._reaches = max(1, math.ceil(reliable_range_m / REACH_STEP_M))
        self._tallies = np.zeros((_TALLIES, TANGENT_BINS), np.int32)
        self._rays = np.zeros((3, TANGENT_BINS, self._reaches), np.int32)
        self._bins = np.zeros((2, TANGENT_BINS), np.bool_)
        self._sectors = np.zeros((2, SECTORS), np.bool_)
        self._furthest_m = np.zeros(TANGENT_BINS)
        self._below_m = np.zeros(TANGENT_BINS)
        self._strips = GroundStripSurvey(range_min_m)
        self._bins_of = bins_of_sectors()
        self._intrinsics: Intrinsics | None = None

    def survey(self, frame: DepthFrame, camera: CameraPose, band: HeightBand, ground_down_m: float | None) -> Evidence:
        """What one frame proves; its depth is (height, width) uint16 in C order."""
        if frame.intrinsics != self._intrinsics:
            self._prepare(frame.intrinsics)
        height_m = math.inf if ground_down_m is None else ground_down_m - float(camera.position_ned_m[2])
        samples, returned, saturated, near, due, contradictions = _survey(
            frame.depth,
            frame.depth_unit_m,
            self._step,
            self._x,
            self._y,
            camera.level,
            np.array(
                [
                    self._range_min_m,
                    self._range_max_m,
                    band.top_m,
                    band.bottom_m,
                    height_m,
                    band.slope,
                    band.ground_m,
                    band.ground_slope,
                ]
            ),
            self._parameters.ground_height_error_m,
            self._reliable_range_m,
            self._tallies,
            self._rays,
            self._tiles,
            self._below_m,
            self._row_work,
            self._row_rays,
        )
        strip = self._strips.survey(frame, camera, height_m)
        fault = ""
        if saturated > _COVERED_FRACTION * samples:
            fault = f"{_percent(saturated, samples)} of the depth frame's pixels are at the maximum, {_SATURATED}"
        elif near > _COVERED_FRACTION * samples:
            share = _percent(near, samples)
            fault = f"the lens is covered: {share} of the depth frame's pixels are nearer than {self._range_min_m:g} m"
        elif returned < _RETURNED_MIN:
            fault = "depth frame is empty: no pixel returned a distance" + (
                ", although the ground is in sight" if self._tallies[[_DUE, _FAR_DUE]].sum() >= _DUE_MIN else ""
            )
        elif due >= _DUE_MIN and contradictions > _CONTRADICTION_FRACTION * due:
            fault = (
                f"depth contradicts the ground: {_percent(contradictions, due)} of the pixels that look at it return from "
                "beneath it; the picture's orientation, the mounting, the height or the lens data are wrong"
            )
        _decide(
            self._tallies,
            self._rays,
            self._tiles,
            self._tile_work,
            self._tile_x,
            self._tile_y,
            camera.level,
            band.top_m,
            band.bottom_m,
            self._parameters.return_fraction_min,
            self._parameters.ground_return_fraction_min,
            strip.is_blind,
            strip.is_ground,
            self._bins_of,
            self._bins,
            self._sectors,
            self._furthest_m,
        )
        below = self._tallies[_BELOW]
        return Evidence(self._sectors[0], self._sectors[1], self._furthest_m, self._rays[2], below, self._below_m, fault)

    def _prepare(self, k: Intrinsics) -> None:
        # A bearing bin must not fall between two columns.
        self._step = max(1, min(_STEP_MAX_PX, int(k.fx_px * TANGENT_STEP)))
        first = self._step // 2
        self._x = (np.arange(first, k.width_px - 1, self._step) - k.cx_px) / k.fx_px
        self._y = (np.arange(first, k.height_px, self._step) - k.cy_px) / k.fy_px
        rows, columns = math.ceil(len(self._y) / _TILE_STEPS), math.ceil(len(self._x) / _TILE_STEPS)
        self._tiles = np.zeros((2, rows, columns), np.int32)
        self._tile_work = np.zeros((2, rows * columns), np.int32)
        side = self._step * _TILE_STEPS
        self._tile_x = (np.minimum(np.arange(columns + 1) * side, k.width_px) - k.cx_px) / k.fx_px
        self._tile_y = (np.minimum(np.arange(rows + 1) * side, k.height_px) - k.cy_px) / k.fy_px
        self._row_work = np.zeros((3, len(self._x)), np.int32)
        self._row_rays = np.zeros((2, len(self._x)))
        self._intrinsics = k


def _percent(part: int, whole: int) -> str:
    return f"{100 * part // max(whole, 1)} %"


@njit(
    "UniTuple(i8,6)(u2[:,::1],f8,i8,f8[::1],f8[::1],f8[:,::1],f8[::1],f8,f8,i4[:,::1],i4[:,:,::1],i4[:,:,::1],f8[::1],i4[:,::1],f8[:,::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _survey(  # type: ignore[no-untyped-def]
    depth, unit, step, x, y, level, limits, ground_error, reliable, tallies, rays, tiles, below_m, row_work, row_rays
):
    """Count samples by bearing bin (tallies), by how far they prove a line of sight free (rays), by place in the picture (tiles).

    limits: range_min, range_max, top and bottom of the band, height above ground, the band's slope, lowest height that is no
    ground, its slope. rays: all, those that returned, returns from within the
    band by their own distance, single ones too. tiles: all, then those that returned. below_m: forward distance of
    the nearest thing right below the band. row_work: bin, ray's end, class of ground; row_rays: ahead, down; of one row, filled
    by a loop without branches. Returns how many samples there are, returned, are saturated, are too near; how many looked at
    the ground within range and returned, and how many of these came from beneath it.
    """
    tallies[:] = 0
    rays[:] = 0
    tiles[:] = 0
    below_m[:] = np.inf
    bins, leaves, grounds = row_work[0], row_work[1], row_work[2]
    aheads, downs = row_rays[0], row_rays[1]
    range_min, range_max, top, bottom, height = limits[0], limits[1], limits[2], limits[3], limits[4]
    slope, lowest, lowest_slope = limits[5], limits[6], limits[7]
    last_reach = np.int32(rays.shape[2] - 1)
    ground_range = _GROUND_RANGE_FRACTION * range_max
    under, over = max(bottom, 0.0), min(top, 0.0)
    due_height = max(height + ground_error, 1e-3)
    bins_per_tangent, reaches_per_m = 1.0 / TANGENT_STEP, 1.0 / REACH_STEP_M
    nearest_raw = np.int32(min(65535.0, math.ceil(range_min / unit)))
    furthest_raw = np.int32(min(65534.0, math.floor(_REAL_MAX_M / unit)))
    reliable_raw = np.int32(min(65534.0, reliable / unit))
    columns = x.shape[0]
    total_returned = saturated = total_near = total_due = contradictions = 0
    for j in range(y.shape[0]):
        row = depth[step // 2 + j * step]
        ahead_row, aside_row = level[0, 1] * y[j] + level[0, 2], level[1, 1] * y[j] + level[1, 2]
        down_row = level[2, 1] * y[j] + level[2, 2]
        for i in range(columns):
            ahead = level[0, 0] * x[i] + ahead_row
            aside = level[1, 0] * x[i] + aside_row
            down = level[2, 0] * x[i] + down_row
            is_ahead = (ahead > 1e-3) & (abs(aside) < TANGENT_MAX * ahead)
            tangent = min(max(aside / ahead, -TANGENT_MAX), TANGENT_MAX)
            b = min(np.int32((tangent + TANGENT_MAX) * bins_per_tangent), np.int32(TANGENT_BINS - 1))
            bins[i] = b if is_ahead else np.int32(-1)
            per_down = ahead / down
            leave = min(reliable, under * per_down if down > 1e-6 else (over * per_down if down < -1e-6 else reliable))
            aheads[i] = ahead
            downs[i] = down
            leaves[i] = min(np.int32(max(leave, 0.0) * reaches_per_m), last_reach)
            grounds[i] = (
                np.int32(2)
                if down * ground_range >= due_height
                else (np.int32(1) if down * _FAR_GROUND_MAX_M >= due_height else np.int32(0))
            )
        tile_row = j // _TILE_STEPS
        u = step // 2
        for i in range(columns):
            raw = np.int32(row[u])
            is_near = np.int32((raw > 0) & (raw < nearest_raw))
            # A single pixel is noise: the one beside it must have returned as well.
            is_valid = (raw >= nearest_raw) & (raw > 0) & (raw != _SATURATED) & (row[u + 1] > 0)
            u += step
            returned = np.int32(is_valid & (raw <= furthest_raw))
            saturated += int(raw == _SATURATED)
            total_near += int(is_near)
            total_returned += int(returned)
            tiles[0, tile_row, i // _TILE_STEPS] += 1
            tiles[1, tile_row, i // _TILE_STEPS] += returned
            b = bins[i]
            if b < 0:
                continue
            tallies[_WANTED, b] += 1
            tallies[_RETURNED, b] += returned
            tallies[_NEAR, b] += is_near
            if grounds[i] == 2:
                tallies[_DUE, b] += 1
                tallies[_DUE_RETURNED, b] += returned
                total_due += is_valid
                z = raw * unit
                contradictions += is_valid and z * downs[i] > _TERRAIN_HEIGHT * height + ground_error + _TERRAIN_SLOPE * z
            elif grounds[i] == 1:
                tallies[_FAR_DUE, b] += 1
            rays[0, b, leaves[i]] += 1
            if raw < nearest_raw or raw > furthest_raw:
                continue
            z = raw * unit
            reach = np.int32(z * aheads[i] * reaches_per_m)
            if returned:
                rays[1, b, min(leaves[i], reach)] += 1
            down, widened = z * downs[i], slope * z
            if raw < reliable_raw and down >= top - widened and down + lowest_slope * z <= lowest:
                if down <= bottom + widened:
                    rays[2, b, min(last_reach, reach)] += 1
                elif down <= bottom + widened + _BELOW_M:
                    tallies[_BELOW, b] += 1
                    below_m[b] = min(below_m[b], z * aheads[i])
    return y.shape[0] * x.shape[0], total_returned, saturated, total_near, total_due, contradictions


@njit("b1(i4[:,:,::1],i8,i8)", cache=True, nogil=True, error_model="numpy")
def _is_empty(tiles, row, column):  # type: ignore[no-untyped-def]
    return tiles[1, row, column] <= _HOLE_RETURNS_MAX * tiles[0, row, column]


@njit("void(i4[:,:,::1],i4[:,::1],f8[::1],f8[::1],f8[:,::1],f8,f8,b1[::1])", cache=True, nogil=True, error_model="numpy")
def _hide_holes(tiles, work, tile_x, tile_y, level, top, bottom, is_blind):  # type: ignore[no-untyped-def]
    """Mark the bearing bins in which a hole reaches into the height band. work: region's tiles, and which tiles are done."""
    rows, columns = tiles.shape[1], tiles.shape[2]
    region, done = work[0], work[1]
    done[:] = 0
    steepness = max(math.sqrt(level[2, 0] ** 2 + level[2, 1] ** 2), 1e-9)
    up_x, up_y = -level[2, 0] / steepness, -level[2, 1] / steepness
    for seed in range(rows * columns):
        if (
            done[seed]
            or tiles[1, seed // columns, seed % columns] > _HOLE_RETURNS_MAX * tiles[0, seed // columns, seed % columns]
        ):
            continue
        region[0] = seed
        done[seed] = 1
        size, at, is_open = 1, 0, False
        while at < size:
            row, column = region[at] // columns, region[at] % columns
            at += 1
            is_open |= (row == 0 and up_y < -_SKYWARD) or (row == rows - 1 and up_y > _SKYWARD)
            is_open |= (column == 0 and up_x < -_SKYWARD) or (column == columns - 1 and up_x > _SKYWARD)
            for side in range(4):
                r = row + (1 if side == 0 else (-1 if side == 1 else 0))
                c = column + (1 if side == 2 else (-1 if side == 3 else 0))
                if 0 <= r < rows and 0 <= c < columns and not done[r * columns + c] and _is_empty(tiles, r, c):
                    done[r * columns + c] = 1
                    region[size] = r * columns + c
                    size += 1
        if is_open or size < _HOLE_TILES_MIN:
            continue
        for k in range(size):
            row, column = region[k] // columns, region[k] % columns
            x, y = (tile_x[column] + tile_x[column + 1]) / 2, (tile_y[row] + tile_y[row + 1]) / 2
            ahead = level[0, 0] * x + level[0, 1] * y + level[0, 2]
            down = level[2, 0] * x + level[2, 1] * y + level[2, 2]
            if ahead <= 1e-3 or not top * ahead <= down * _HOLE_DISTANCE_M <= bottom * ahead:
                continue
            low, high = TANGENT_BINS, -1
            for side in range(2):
                aside = level[1, 0] * tile_x[column + side] + level[1, 1] * y + level[1, 2]
                ahead = max(level[0, 0] * tile_x[column + side] + level[0, 1] * y + level[0, 2], 1e-3)
                tangent = min(max(aside / ahead, -TANGENT_MAX), TANGENT_MAX)
                b = min(int((tangent + TANGENT_MAX) / TANGENT_STEP), TANGENT_BINS - 1)
                low, high = min(low, b), max(high, b)
            for b in range(low, high + 1):
                is_blind[b] = True


@njit(
    "void(i4[:,::1],i4[:,:,::1],i4[:,:,::1],i4[:,::1],f8[::1],f8[::1],f8[:,::1],f8,f8,f8,f8,b1[::1],b1[::1],"
    "i4[:,::1],b1[:,::1],b1[:,::1],f8[::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _decide(  # type: ignore[no-untyped-def]
    tallies,
    rays,
    tiles,
    tile_work,
    tile_x,
    tile_y,
    level,
    top,
    bottom,
    fraction_min,
    ground_fraction_min,
    is_strip_blind,
    is_ground,
    bins_of,
    bins,
    sectors,
    furthest,
):
    """Fill furthest (TANGENT_BINS,) and sectors (2, 360), which are hidden and which of these blind, from what was counted."""
    bins[:] = False
    is_hidden, is_blind = bins[0], bins[1]
    for b in range(TANGENT_BINS):
        first, end = max(b - 1, 0), min(b + 2, TANGENT_BINS)
        wanted = returned = near = due = due_returned = 0
        for k in range(first, end):
            wanted += tallies[_WANTED, k]
            returned += tallies[_RETURNED, k]
            near += tallies[_NEAR, k]
            due += tallies[_DUE, k]
            due_returned += tallies[_DUE_RETURNED, k]
        if returned < max(_RETURNED_MIN, fraction_min * wanted) and not is_ground[b]:
            is_hidden[first:end] = True
        if near > _NEAR_FRACTION_MAX * wanted or (due >= _DUE_MIN and due_returned < ground_fraction_min * due):
            is_blind[first:end] = True
        is_blind[b] |= is_strip_blind[b]
    _hide_holes(tiles, tile_work, tile_x, tile_y, level, top, bottom, is_blind)
    for sector in range(sectors.shape[1]):
        sectors[1, sector] = False
        for b in range(bins_of[sector, 0], bins_of[sector, 1] + 1):
            sectors[1, sector] |= is_blind[b]
        sectors[0, sector] = sectors[1, sector] or bins_of[sector, 0] > bins_of[sector, 1]
        for b in range(bins_of[sector, 0], bins_of[sector, 1] + 1):
            sectors[0, sector] |= is_hidden[b]
    for b in range(TANGENT_BINS):
        furthest[b] = 0.0
        passing = back = 0
        for k in range(rays.shape[2] - 1, 0, -1):
            passing += rays[0, b, k]
            back += rays[1, b, k]
            if back >= max(_REACH_RETURNS_MIN, _REACH_FRACTION * passing):
                furthest[b] = k * REACH_STEP_M
                break
