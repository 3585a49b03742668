"""Sectors of bearings: which were seen, which were not. Bearings are in rad, clockwise from north, in [-pi, pi]."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.parameters import PerceptionParameters
from perception.types import Intrinsics

WHOLE_CIRCLE = np.array([[-math.pi, math.pi]])

_EDGES_RAD = np.linspace(-math.pi / 2, math.pi / 2, 361)
"""Borders of the half-degree sectors in front of the camera, relative to its heading; what lies behind is never seen."""
_HEIGHTS = 12


def in_view(
    camera: CameraPose, intrinsics: Intrinsics, vehicle_down_m: float, parameters: PerceptionParameters
) -> NDArray[np.bool_]:
    """(360,) which half-degree sectors ahead show enough of the height band around the vehicle.

    Bearings are the camera's: what is 1 m away a camera 0.1 m ahead of the vehicle sees up to 4 degrees further aside.
    A sector is in view if both its borders are: at `look_distance_m`, at least `look_fraction_min` of the band lies in the
    picture. What is nearer shows less of the band, what is further shows more.
    """
    k = intrinsics
    lens = np.array([k.fx_px, k.fy_px, k.cx_px, k.cy_px, k.width_px - 1, k.height_px - 1], np.float64)
    seen = np.empty(len(_EDGES_RAD), np.bool_)
    above_m = vehicle_down_m - float(camera.position_ned_m[2])
    look = (parameters.look_distance_m, parameters.band_m, parameters.look_fraction_min)
    _borders_in_view(_EDGES_RAD, camera.level, lens, above_m, *look, seen)
    return seen[:-1] & seen[1:]


@njit("void(f8[::1],f8[:,::1],f8[::1],f8,f8,f8,f8,b1[::1])", cache=True, nogil=True, error_model="numpy")
def _borders_in_view(bearings, level, lens, middle, distance, band, fraction_min, seen):  # type: ignore[no-untyped-def]
    """lens: fx, fy, cx, cy, largest column and row. middle: vehicle's altitude, metres below the camera."""
    for i in range(bearings.shape[0]):
        ahead, aside = distance * math.cos(bearings[i]), distance * math.sin(bearings[i])
        inside = 0
        for j in range(_HEIGHTS):
            down = middle + ((j + 0.5) / _HEIGHTS * 2 - 1) * band
            # Optical coordinates: the level frame's axes forward, right, down are the rows of `level`.
            z = level[0, 2] * ahead + level[1, 2] * aside + level[2, 2] * down
            if z > 1e-6:
                u = lens[2] + lens[0] * (level[0, 0] * ahead + level[1, 0] * aside + level[2, 0] * down) / z
                v = lens[3] + lens[1] * (level[0, 1] * ahead + level[1, 1] * aside + level[2, 1] * down) / z
                inside += 0.0 <= u <= lens[4] and 0.0 <= v <= lens[5]
        seen[i] = inside >= fraction_min * _HEIGHTS


def unseen_sectors(seen: NDArray[np.bool_], heading_rad: float) -> NDArray[np.float64]:
    """(k, 2) bearings [from, to) outside the `seen` sectors (360,) ahead; from < to, split at south."""
    runs = _runs(seen)
    if not runs:
        return WHOLE_CIRCLE.copy()
    half = math.pi / 2
    step = math.pi / len(seen)
    out: list[tuple[float, float]] = []
    next_starts = [first for first, _ in runs[1:]] + [runs[0][0] + 2 * len(seen)]
    for (_, end), start in zip(runs, next_starts, strict=True):
        begins = _wrapped(heading_rad + end * step - half)
        ends = begins + (start - end) * step
        if ends <= math.pi:
            out.append((begins, ends))
        else:
            out.extend([(begins, math.pi), (-math.pi, ends - 2 * math.pi)])
    return np.array(sorted(pair for pair in out if pair[1] > pair[0]))


def _runs(seen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """[first, end) of every unbroken run of seen sectors."""
    flags, runs, at = seen.tobytes(), [], 0
    while (first := flags.find(b"\x01", at)) >= 0:
        at = flags.find(b"\x00", first)
        at = len(flags) if at < 0 else at
        runs.append((first, at))
    return runs


def _wrapped(angle_rad: float) -> float:
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi
