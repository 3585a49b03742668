"""From surface points to discs: something round becomes one disc, anything else a row of small ones.

The front of a disc lies at most `surface_tolerance_m` before the surface; the rest of it covers the back that is not seen. Each
point is looked at a fixed number of times, so the work grows with the number of points alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_MAX, TANGENT_STEP
from perception.extraction.surfaces import SurfacePoints
from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.parameters import PerceptionParameters

_ROUND_ANGLE_MAX_RAD = math.radians(75)
_EDGE_BIN_FRACTION = 0.3
"""The outermost bearing bin of a surface is on average filled this far from its centre."""
_FLAT_LENGTH_MIN_M = 0.15
_OPEN_PIECES = 6
_CHORD_FRACTION = 0.5
"""A piece of a near surface is no longer than this share of its distance: its disc must not reach the vehicle."""
_BESIDE_BINS = 3
_EVIDENCE_HALF = 2.0
"""A surface with this many times the pixels it needs is believed half way."""
_FAR_FRACTION = 0.5
"""At the range limit a disc is believed this much less than one nearby."""
_CUT_FRACTION = 0.8
"""A disc that something cuts off is believed this much less than a whole one."""


@dataclass(frozen=True, slots=True)
class Covering:
    """Discs in the level frame of the camera, nearest surface first.

    discs: (n, 3) forward_m, right_m, radius_m. sigma_m, confidence, is_whole: (n,), see `Sighting`.
    """

    discs: NDArray[np.float64]
    sigma_m: NDArray[np.float64]
    confidence: NDArray[np.float64]
    is_whole: NDArray[np.bool_]


class Coverer:
    """Covers the surfaces of one camera; holds all buffers."""

    def __init__(self, parameters: PerceptionParameters, range_max_m: float, points_max: int) -> None:
        bulge = parameters.surface_tolerance_m
        self._discs_max = parameters.discs_max
        self._numbers = np.array(
            [
                parameters.disc_radius_min_m,
                parameters.disc_radius_max_m,
                parameters.round_radius_max_m,
                bulge,
                parameters.depth_noise_1_m,
                2 * math.sqrt(max(bulge**2, 2 * parameters.disc_radius_max_m * bulge - bulge**2)),
                range_max_m,
            ]
        )
        self._discs = np.zeros((points_max, 5))
        self._is_whole = np.zeros(points_max, np.bool_)
        self._pieces = np.zeros((points_max, 11))
        self._piece_of = np.zeros(points_max, np.int32)

    def cover(self, points: SurfacePoints, seen: NDArray[np.bool_], camera: CameraPose, reliable_range_m: float) -> Covering:
        """At most `discs_max` discs, those with the nearest surfaces. seen: (360,) half-degree sectors ahead."""
        number = _cover(
            points.forward_m,
            points.right_m,
            points.half_depth_m,
            points.bin,
            points.starts,
            points.evidence,
            points.nearest_m,
            points.is_excluded,
            seen,
            reliable_range_m / max(float(camera.level[0, 2]), 1e-3),
            self._numbers,
            self._discs,
            self._is_whole,
            self._pieces,
            self._piece_of,
        )
        gap = np.hypot(self._discs[:number, 0], self._discs[:number, 1]) - self._discs[:number, 2]
        nearest = np.argsort(gap, kind="stable")[: self._discs_max]
        discs = self._discs[nearest]
        return Covering(discs[:, :3], discs[:, 3], discs[:, 4], self._is_whole[nearest])


@njit("b1(f8,f8,b1[::1])", cache=True, nogil=True, error_model="numpy")
def _all_seen(low, high, seen):  # type: ignore[no-untyped-def]
    """Whether all half-degree sectors from one bearing to another were seen."""
    per_rad = seen.shape[0] / math.pi
    first, last = math.floor((low + math.pi / 2) * per_rad), math.floor((high + math.pi / 2) * per_rad)
    if first < 0 or last >= seen.shape[0]:
        return False
    return np.all(seen[first : last + 1])


@njit("b1(f8[::1],f8[::1],f8[::1],i4[::1],f8[::1],f8[::1])", cache=True, nogil=True, error_model="numpy")
def _round(forward, right, half_depth, bins, numbers, disc):  # type: ignore[no-untyped-def]
    """Fill `disc` with the circle of the points' silhouette and distance, if they lie on it."""
    radius_min, radius_max, round_max, bulge, noise_1_m = numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]
    count = forward.shape[0]
    low = math.atan((bins[0] + 0.5 - _EDGE_BIN_FRACTION) * TANGENT_STEP - TANGENT_MAX)
    high = math.atan((bins[count - 1] + 0.5 + _EDGE_BIN_FRACTION) * TANGENT_STEP - TANGENT_MAX)
    half, middle = (high - low) / 2, (high + low) / 2
    if half > _ROUND_ANGLE_MAX_RAD:
        return False
    central, near = 0, 0.0
    for i in range(count):
        if abs(math.atan2(right[i], forward[i]) - middle) <= max(half / 3, math.atan(TANGENT_STEP)):
            near += math.hypot(forward[i], right[i])
            central += 1
    if central == 0:
        return False
    near /= central
    sine = math.sin(half)
    silhouette = near * sine / (1 - sine)
    if silhouette > round_max:
        return False
    radius = max(silhouette, radius_min)
    centre = near + silhouette
    ahead, aside = centre * math.cos(middle), centre * math.sin(middle)
    most, least = -1e18, 1e18
    for i in range(count):
        outside = math.hypot(forward[i] - ahead, right[i] - aside) + half_depth[i] - radius
        most = max(most, outside)
        # What lies behind the first point of a bearing is the top of the thing, or its inside.
        if i == 0 or bins[i] != bins[i - 1]:
            least = min(least, outside)
    noise = noise_1_m * near * near / 2
    if most > bulge + noise or (radius > radius_max / 2 and least < -0.4 * radius - noise):
        return False
    disc[0], disc[1], disc[2] = ahead, aside, radius
    return True


@njit("b1(f8[::1],i8,i8,f8,f8[::1],b1[::1],b1[::1],f8)", cache=True, nogil=True, error_model="numpy")
def _is_isolated(disc, first, last, bulge, nearest, is_excluded, seen, reliable):  # type: ignore[no-untyped-def]
    """Whether a round disc over bins [first, last] is cut off by nothing: edge of view, range, something nearer or left out."""
    distance = math.hypot(disc[0], disc[1])
    bearing, half = math.atan2(disc[1], disc[0]), math.asin(min(1.0, disc[2] / max(distance, 1e-6)))
    if disc[0] + disc[2] > reliable or not _all_seen(bearing - half - TANGENT_STEP, bearing + half + TANGENT_STEP, seen):
        return False
    for b in range(max(first - _BESIDE_BINS, 0), min(last + _BESIDE_BINS, nearest.shape[0] - 1) + 1):
        is_beside = b < first or b > last
        if is_excluded[b] or (is_beside and nearest[b] < disc[0] + disc[2] + bulge):
            return False
    return True


@njit("i8(f8[::1],f8[::1],f8[::1],f8[::1],f8[:,::1],i4[::1],f8[:,::1])", cache=True, nogil=True, error_model="numpy")
def _row(forward, right, half_depth, numbers, pieces, piece_of, discs):  # type: ignore[no-untyped-def]
    """Fill `discs` with small ones along the points; returns how many.

    Columns of a piece: rectangle ahead_min, ahead_max, aside_min, aside_max; first point, last point; largest half depth.
    """
    radius_min, radius_max, bulge, chord = numbers[0], numbers[1], numbers[3], numbers[5]
    count = 0
    for i in range(forward.shape[0]):
        mine = -1
        for k in range(count - 1, max(count - 1 - _OPEN_PIECES, -1), -1):
            low, high = min(pieces[k, 0], forward[i]), max(pieces[k, 1], forward[i])
            left, rightmost = min(pieces[k, 2], right[i]), max(pieces[k, 3], right[i])
            length, width = high - low, rightmost - left
            most = min(chord, _CHORD_FRACTION * low)
            if length <= most and width <= most and length * length + width * width <= 1.5 * most * most:
                pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3] = low, high, left, rightmost
                mine = k
                break
        if mine < 0:
            mine = count
            count += 1
            pieces[mine, 0] = pieces[mine, 1] = pieces[mine, 4] = forward[i]
            pieces[mine, 2] = pieces[mine, 3] = pieces[mine, 5] = right[i]
            pieces[mine, 8] = pieces[mine, 10] = 0.0
        pieces[mine, 6], pieces[mine, 7] = forward[i], right[i]
        pieces[mine, 8] = max(pieces[mine, 8], half_depth[i])
        piece_of[i] = mine
    for k in range(count):
        # Pushed back behind the piece, away from the camera, so far that the disc bulges out by the tolerance only.
        along_x, along_y = pieces[k, 6] - pieces[k, 4], pieces[k, 7] - pieces[k, 5]
        x, y = (pieces[k, 6] + pieces[k, 4]) / 2, (pieces[k, 7] + pieces[k, 5]) / 2
        distance, length = math.hypot(x, y), math.hypot(along_x, along_y)
        half = length / 2 + TANGENT_STEP * x / 2
        # Across the line of sight the disc may stick out into what is seen to be free by little more than it bulges.
        across = abs(along_y * x - along_x * y) / distance / 2 + TANGENT_STEP * x / 2
        radius = min((half * half + bulge * bulge) / (2 * bulge), radius_max, across + 1.5 * bulge)
        radius = max(radius, radius_min, half)
        push = max(0.0, math.sqrt(radius * radius - half * half) - pieces[k, 8])
        away_x, away_y = x / distance, y / distance
        if length > _FLAT_LENGTH_MIN_M:
            away_x, away_y = -along_y / length, along_x / length
            if away_x * x + away_y * y < 0:
                away_x, away_y = -away_x, -away_y
        discs[k, 0], discs[k, 1], discs[k, 2] = x + push * away_x, y + push * away_y, radius
    for i in range(forward.shape[0]):
        k = piece_of[i]
        reach = math.hypot(forward[i] - discs[k, 0], right[i] - discs[k, 1]) + half_depth[i]
        pieces[k, 10] = max(pieces[k, 10], reach)
    for k in range(count):
        discs[k, 2] = max(discs[k, 2], pieces[k, 10] - bulge / 2)
    return count


@njit(
    "i8(f8[::1],f8[::1],f8[::1],i4[::1],i4[::1],f8[::1],f8[::1],b1[::1],b1[::1],f8,f8[::1],f8[:,::1],b1[::1],f8[:,::1],i4[::1])",
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _cover(  # type: ignore[no-untyped-def]
    forward,
    right,
    half_depth,
    bins,
    starts,
    evidence,
    nearest,
    is_excluded,
    seen,
    reliable,
    numbers,
    discs,
    is_whole,
    pieces,
    piece_of,
):
    """Fill discs (forward, right, radius, sigma, confidence) and is_whole; returns how many."""
    total = 0
    for surface in range(starts.shape[0] - 1):
        start, end = starts[surface], starts[surface + 1]
        of_surface = discs[total:]
        is_round = _round(forward[start:end], right[start:end], half_depth[start:end], bins[start:end], numbers, of_surface[0])
        count = 1
        if not is_round:
            count = _row(forward[start:end], right[start:end], half_depth[start:end], numbers, pieces, piece_of, of_surface)
        for k in range(total, total + count):
            whole = is_round and _is_isolated(
                discs[k], bins[start], bins[end - 1], numbers[3], nearest, is_excluded, seen, reliable
            )
            bearing = math.atan2(discs[k, 1], discs[k, 0])
            is_cut = not _all_seen(bearing, bearing, seen) or discs[k, 0] + discs[k, 2] > reliable
            near = max(0.0, math.hypot(discs[k, 0], discs[k, 1]) - discs[k, 2])
            share = min(near / numbers[6], 1.0)
            believed = evidence[surface] / (evidence[surface] + _EVIDENCE_HALF)
            discs[k, 3] = numbers[4] * near * near
            discs[k, 4] = believed * (1.0 - _FAR_FRACTION * share * share) * (_CUT_FRACTION if is_cut else 1.0)
            is_whole[k] = whole
        total += count
    return total
