"""The furthest ground that the picture shows: it lies right below the height band, so what hides one mostly hides the other.

A glare or a cover over the horizon cannot be told from the open sky by what it covers of the sky. It is told by what it covers
of the ground: the ground is looked at in strips, each between two distances, from 30 m down to 6 m. The first one in which a
quarter of the bearings that show ground return enough pixels says what the camera can do today on this ground in this light;
every bearing must then return at least two fifths of that in the same strip, be it the ground or what stands on it.

If the ground at 15 to 19 m is in the picture and no strip from there on returns anything to speak of, nothing is believed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.types import DepthFrame, Intrinsics

_BORDERS_M = np.array([30.0, 24.0, 19.0, 15.0, 12.0, 9.5, 7.5, 6.0])
_REQUIRED_M = 15.0
_REQUIRED_PIXELS = 100
_LITTLE_SHARE = 0.15
"""Bare ground at 15 to 19 m returns several times as many of its pixels; speckle on a cover returns fewer."""
_REFERENCE_PIXELS = 80
_REFERENCE_BINS = 8
_SHARE_MIN = 0.4
_RETURN_MAX_M = 40.0
_UPRIGHT_MIN = 0.3
_FITTING_PIXELS_MIN = 8
_INVERSE_TOLERANCE_1_M = 0.012
"""Three times the noise of a D435's inverse depth."""
_HEIGHT_TOLERANCE = 0.15
_NOTHING, _FOUND, _MISSED = 0, 1, 2


@dataclass(frozen=True, slots=True)
class GroundStrip:
    """is_blind: (TANGENT_BINS,) where far ground or what stands before it should have returned and did not.

    is_ground: (TANGENT_BINS,) where returns lie at the distance of the ground: speckle on a covered lens does not.
    """

    is_blind: NDArray[np.bool_]
    is_ground: NDArray[np.bool_]


class GroundStripSurvey:
    """Looks at every pixel of the strips down to the first that tells something; holds all buffers."""

    def __init__(self, range_min_m: float) -> None:
        self._range_min_m = range_min_m
        self._counts = np.zeros((4, TANGENT_BINS), np.int32)
        self._sorted = np.zeros((2, TANGENT_BINS), np.int32)
        self._flags = np.zeros((2, TANGENT_BINS), np.bool_)
        self._intrinsics: Intrinsics | None = None

    def survey(self, frame: DepthFrame, camera: CameraPose, height_m: float) -> GroundStrip:
        """height_m: of the camera above the ground, infinite if that is not known: then nothing is told."""
        if frame.intrinsics != self._intrinsics:
            k = frame.intrinsics
            self._x = (np.arange(k.width_px) - k.cx_px) / k.fx_px
            self._lens = np.array([k.fy_px, k.cy_px], np.float64)
            self._intrinsics = k
        if math.isfinite(height_m) and height_m > 0.0:
            _look_at_strips(
                frame.depth,
                float(frame.depth_unit_m),
                self._range_min_m,
                self._x,
                self._lens,
                camera.level,
                height_m,
                _BORDERS_M,
                self._counts,
                self._sorted,
                self._flags,
            )
        else:
            self._flags[:] = False
        return GroundStrip(self._flags[0], self._flags[1])


@njit(
    "void(u2[:,::1],f8,f8,f8[::1],f8[::1],f8[:,::1],f8,f8,f8,i4[:,::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _count_strip(depth, unit, range_min, x, lens, level, height, far_m, near_m, counts):  # type: ignore[no-untyped-def]
    """Add up wanted, returned, fitting the ground (rows 0, 1, 2 of counts, by bearing bin) between two depths of the ground."""
    nearest = np.int32(math.ceil(range_min / unit))
    furthest = np.int32(min(65534.0, _RETURN_MAX_M / unit))
    rows = depth.shape[0]
    for u in range(depth.shape[1]):
        side = level[2, 0] * x[u] + level[2, 2]
        upper = lens[1] + lens[0] * (height / far_m - side) / level[2, 1]
        lower = lens[1] + lens[0] * (height / near_m - side) / level[2, 1]
        first, end = int(min(max(upper, 0.0), rows)), int(min(max(lower, 0.0), rows))
        if first >= end:
            continue
        y = ((first + end) / 2 - lens[1]) / lens[0]
        ahead = level[0, 0] * x[u] + level[0, 1] * y + level[0, 2]
        aside = level[1, 0] * x[u] + level[1, 1] * y + level[1, 2]
        if ahead <= 1e-3 or abs(aside) >= TANGENT_MAX * ahead:
            continue
        returned = fitting = 0
        per_row, inverse = level[2, 1] / lens[0] / height, (side - level[2, 1] * lens[1] / lens[0]) / height
        for v in range(first, end):
            raw = np.int32(depth[v, u])
            if nearest <= raw <= furthest:
                returned += 1
                expected = inverse + per_row * v
                fitting += abs(1.0 / (raw * unit) - expected) <= _INVERSE_TOLERANCE_1_M + _HEIGHT_TOLERANCE * expected
        b = min(int((aside / ahead + TANGENT_MAX) / TANGENT_STEP), TANGENT_BINS - 1)
        counts[0, b] += end - first
        counts[1, b] += returned
        counts[2, b] += fitting


@njit(
    "void(u2[:,::1],f8,f8,f8[::1],f8[::1],f8[:,::1],f8,f8[::1],i4[:,::1],i4[:,::1],b1[:,::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _look_at_strips(  # type: ignore[no-untyped-def]
    depth, unit, range_min, x, lens, level, height, borders, counts, in_order, flags
):
    """Fill flags (2, TANGENT_BINS): is_blind, is_ground. counts: wanted, returned, fitting; fitting in all strips so far."""
    flags[:] = False
    counts[3] = 0
    if level[2, 1] < _UPRIGHT_MIN:
        return
    outcome, wanted_there, reference = _NOTHING, 0, 0
    for strip in range(borders.shape[0] - 1):
        counts[:3] = 0
        _count_strip(depth, unit, range_min, x, lens, level, height, borders[strip], borders[strip + 1], counts)
        for b in range(TANGENT_BINS):
            counts[3, b] += counts[2, b]
        wanted_there = 0
        for b in range(1, TANGENT_BINS - 1):
            wanted_there = max(wanted_there, counts[0, b - 1] + counts[0, b] + counts[0, b + 1])
        # What stands in the strip returns more than the ground does: the ground is compared with the ground.
        judged = judged_of_ground = 0
        for b in range(1, TANGENT_BINS - 1):
            if 2 * (counts[0, b - 1] + counts[0, b] + counts[0, b + 1]) > wanted_there:
                in_order[0, judged] = counts[1, b - 1] + counts[1, b] + counts[1, b + 1]
                if 2 * (counts[2, b - 1] + counts[2, b] + counts[2, b + 1]) > in_order[0, judged]:
                    in_order[1, judged_of_ground] = in_order[0, judged]
                    judged_of_ground += 1
                judged += 1
        if not judged:
            continue
        in_order[0, :judged].sort()
        in_order[1, :judged_of_ground].sort()
        reference = in_order[1, (3 * judged_of_ground) // 4] if judged_of_ground >= _REFERENCE_BINS else 0
        if reference >= _REFERENCE_PIXELS:
            outcome = _FOUND
            break
        returns_little = in_order[0, (3 * judged) // 4] < _LITTLE_SHARE * wanted_there
        if returns_little and borders[strip + 1] <= _REQUIRED_M and wanted_there >= _REQUIRED_PIXELS:
            outcome = _MISSED
            break
    for b in range(TANGENT_BINS):
        first, end = max(b - 1, 0), min(b + 2, TANGENT_BINS)
        wanted = returned = fitting = 0
        for k in range(first, end):
            wanted += counts[0, k]
            returned += counts[1, k]
            fitting += counts[3, k]
        flags[1, b] = fitting >= _FITTING_PIXELS_MIN
        if outcome == _FOUND and wanted > 0 and returned * wanted_there < _SHARE_MIN * reference * wanted:
            flags[0, first:end] = True
    if outcome == _MISSED:
        flags[0] = True
