"""From surface points to discs: something round becomes one disc, anything else a row of small ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.cells import SurfacePoints
from perception.extraction.bearing_bins import TANGENT_STEP, TANGENTS
from perception.parameters import PerceptionParameters

_ROUND_ANGLE_MAX_RAD = math.radians(75)
_EDGE_BIN_FRACTION = 0.3
"""The outermost bearing bin of a surface is on average filled this far from its centre."""
_FLAT_LENGTH_MIN_M = 0.15
_OPEN_PIECES = 6

Disc = tuple[float, float, float]


def cover(points: SurfacePoints, parameters: PerceptionParameters) -> NDArray[np.float64]:
    """Discs (n, 3) forward_m, right_m, radius_m in the level frame that contain the visible surfaces.

    The front of a disc lies at most `surface_tolerance_m` before the surface; the rest of it covers the back that is not seen.
    """
    discs: list[Disc] = []
    if len(points.label):
        starts = np.flatnonzero(np.diff(points.label, prepend=-1))
        for start, end in zip(starts, [*starts[1:], len(points.label)], strict=True):
            one = _round(points, int(start), int(end), parameters)
            discs.extend([one] if one is not None else _row(points, int(start), int(end), parameters))
    return np.array(discs, np.float64).reshape(-1, 3)


def _round(points: SurfacePoints, start: int, end: int, parameters: PerceptionParameters) -> Disc | None:
    """The circle with the silhouette and the distance of points [start, end), if they lie on it."""
    first, last = TANGENTS[points.bin[start]], TANGENTS[points.bin[end - 1]]
    low = math.atan(first - _EDGE_BIN_FRACTION * TANGENT_STEP)
    high = math.atan(last + _EDGE_BIN_FRACTION * TANGENT_STEP)
    half, middle = (high - low) / 2, (high + low) / 2
    if half > _ROUND_ANGLE_MAX_RAD:
        return None
    forward, right = points.forward_m[start:end], points.right_m[start:end]
    central = np.abs(np.arctan2(right, forward) - middle) <= max(half / 3, math.atan(TANGENT_STEP))
    if not central.any():
        return None
    near = float(np.hypot(forward[central], right[central]).mean())
    sine = math.sin(half)
    silhouette = near * sine / (1 - sine)
    if silhouette > parameters.round_radius_max_m:
        return None
    radius = max(silhouette, parameters.disc_radius_min_m)
    centre = near + silhouette
    ahead, aside = centre * math.cos(middle), centre * math.sin(middle)
    outside = np.hypot(forward - ahead, right - aside) + points.half_depth_m[start:end] - radius
    noise = parameters.depth_noise_1_m * near**2 / 2
    if outside.max() > parameters.surface_tolerance_m + noise:
        return None
    if radius > parameters.disc_radius_max_m / 2 and outside.min() < -0.4 * radius - noise:
        return None
    return ahead, aside, radius


class _Piece:
    """Neighbouring points that one disc covers, and the rectangle around them."""

    __slots__ = ("ahead_max", "ahead_min", "aside_max", "aside_min", "points")

    def __init__(self, ahead: float, aside: float) -> None:
        self.ahead_min = self.ahead_max = ahead
        self.aside_min = self.aside_max = aside
        self.points: list[tuple[float, float, float]] = []

    def takes(self, ahead: float, aside: float, chord: float) -> bool:
        """Widen the rectangle by a point unless it would become too long for one disc."""
        low = ahead if ahead < self.ahead_min else self.ahead_min
        high = ahead if ahead > self.ahead_max else self.ahead_max
        left = aside if aside < self.aside_min else self.aside_min
        right = aside if aside > self.aside_max else self.aside_max
        length, width = high - low, right - left
        if length > chord or width > chord or length * length + width * width > 1.5 * chord * chord:
            return False
        self.ahead_min, self.ahead_max, self.aside_min, self.aside_max = low, high, left, right
        return True


def _row(points: SurfacePoints, start: int, end: int, parameters: PerceptionParameters) -> list[Disc]:
    """Small discs along points [start, end)."""
    bulge = parameters.surface_tolerance_m
    chord = 2 * math.sqrt(max(bulge**2, 2 * parameters.disc_radius_max_m * bulge - bulge**2))
    pieces: list[_Piece] = []
    for point in zip(
        points.forward_m[start:end].tolist(),
        points.right_m[start:end].tolist(),
        points.half_depth_m[start:end].tolist(),
        strict=True,
    ):
        for piece in pieces[: -_OPEN_PIECES - 1 : -1]:
            if piece.takes(point[0], point[1], chord):
                break
        else:
            piece = _Piece(point[0], point[1])
            pieces.append(piece)
        piece.points.append(point)
    return [_piece_disc(piece.points, parameters) for piece in pieces]


def _piece_disc(points: list[tuple[float, float, float]], parameters: PerceptionParameters) -> Disc:
    """A disc pushed back behind the piece, away from the camera, so far that it bulges out by the tolerance only."""
    bulge = parameters.surface_tolerance_m
    (x0, y0, _), (x1, y1, _) = points[0], points[-1]
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    distance = math.hypot(x, y)
    half_depth = max([point[2] for point in points])
    along_x, along_y = x1 - x0, y1 - y0
    length = math.hypot(along_x, along_y)
    half = length / 2 + TANGENT_STEP * x / 2
    # Across the line of sight the disc may stick out into what is seen to be free by little more than it bulges.
    across = abs(along_y * x - along_x * y) / distance / 2 + TANGENT_STEP * x / 2
    radius = min((half * half + bulge * bulge) / (2 * bulge), parameters.disc_radius_max_m, across + 1.5 * bulge)
    radius = max(radius, parameters.disc_radius_min_m, half)
    push = max(0.0, math.sqrt(radius * radius - half * half) - half_depth)
    if length > _FLAT_LENGTH_MIN_M:
        away_x, away_y = -along_y / length, along_x / length
        if away_x * x + away_y * y < 0:
            away_x, away_y = -away_x, -away_y
    else:
        away_x, away_y = x / distance, y / distance
    x, y = x + push * away_x, y + push * away_y
    furthest = max([math.hypot(px - x, py - y) + half for px, py, half in points])
    return x, y, max(radius, furthest - bulge / 2)
