"""Sectors of bearings: which were seen, which were not. Bearings are in rad, clockwise from north, in [-pi, pi]."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.parameters import PerceptionParameters
from perception.types import Intrinsics

WHOLE_CIRCLE = np.array([[-math.pi, math.pi]])

_EDGES_RAD = np.linspace(-math.pi / 2, math.pi / 2, 361)
"""Borders of the half-degree sectors in front of the camera, relative to its heading; what lies behind is never seen."""
_HEIGHTS = 12
_GROUND_STEP_PX = 8
_GROUND_SECTOR_RAD = math.radians(5)
_GROUND_RANGE_FRACTION = 0.95
_GROUND_PIXELS_MIN = 8


def in_view(
    camera: CameraPose, intrinsics: Intrinsics, vehicle_down_m: float, parameters: PerceptionParameters
) -> NDArray[np.bool_]:
    """(360,) which half-degree sectors ahead show enough of the height band around the vehicle.

    A sector is in view if both its borders are: at `look_distance_m`, at least `look_fraction_min` of the band lies in the
    picture. What is nearer shows less of the band, what is further shows more.
    """
    distance = parameters.look_distance_m
    ahead, aside = distance * np.cos(_EDGES_RAD), distance * np.sin(_EDGES_RAD)
    offset = (np.arange(_HEIGHTS) + 0.5) / _HEIGHTS * 2 - 1
    down = vehicle_down_m + offset * parameters.band_m - float(camera.position_ned_m[2])
    level = camera.level
    # Optical coordinates (361, heights): the level frame's axes forward, right, down are the rows of `level`.
    z = (level[0, 2] * ahead + level[1, 2] * aside)[:, None] + level[2, 2] * down
    x = (level[0, 0] * ahead + level[1, 0] * aside)[:, None] + level[2, 0] * down
    y = (level[0, 1] * ahead + level[1, 1] * aside)[:, None] + level[2, 1] * down
    in_front = z > 1e-6
    z = np.where(in_front, z, 1.0)
    u, v = intrinsics.fx_px * x / z + intrinsics.cx_px, intrinsics.fy_px * y / z + intrinsics.cy_px
    inside = in_front & (u >= 0) & (u <= intrinsics.width_px - 1) & (v >= 0) & (v <= intrinsics.height_px - 1)
    seen: NDArray[np.bool_] = inside.mean(axis=1) >= parameters.look_fraction_min
    return seen[:-1] & seen[1:]


class GroundCheck:
    """Where the ground must have been seen but nothing was: is the lens covered?

    A depth camera returns nothing both for the open sky and from behind a finger. What lies below the horizon decides: where
    the known height and attitude put the ground within range, something must return, the ground or what stands before it.
    """

    def __init__(self, parameters: PerceptionParameters, range_max_m: float) -> None:
        self._fraction_min = parameters.ground_return_fraction_min
        self._depth_max_m = _GROUND_RANGE_FRACTION * range_max_m

    def blind(
        self, depth: NDArray[np.uint16], intrinsics: Intrinsics, camera: CameraPose, ground_down_m: float | None
    ) -> tuple[NDArray[np.bool_], bool]:
        """(360,) half-degree sectors ahead in which the ground should have returned and did not; whether any ground was due."""
        blind = np.zeros(len(_EDGES_RAD) - 1, np.bool_)
        if ground_down_m is None:
            return blind, False
        level, step = camera.level, _GROUND_STEP_PX
        x = (np.arange(step // 2, intrinsics.width_px, step) - intrinsics.cx_px) / intrinsics.fx_px
        y = ((np.arange(step // 2, intrinsics.height_px, step) - intrinsics.cy_px) / intrinsics.fy_px)[:, None]
        down = level[2, 0] * x + level[2, 1] * y + level[2, 2]
        height_m = ground_down_m - float(camera.position_ned_m[2])
        due = down * self._depth_max_m >= max(height_m, 1e-3)
        if not due.any():
            return blind, False
        ahead, aside = level[0, 0] * x + level[0, 1] * y + level[0, 2], level[1, 0] * x + level[1, 1] * y + level[1, 2]
        bearing = np.arctan2(aside[due], ahead[due])
        sectors = round(math.pi / _GROUND_SECTOR_RAD)
        number = np.clip(((bearing + math.pi / 2) / _GROUND_SECTOR_RAD).astype(np.intp), 0, sectors - 1)
        wanted = np.bincount(number, minlength=sectors)
        returned = np.bincount(number, depth[step // 2 :: step, step // 2 :: step][due] > 0, sectors)
        empty = (wanted >= _GROUND_PIXELS_MIN) & (returned < self._fraction_min * wanted)
        is_due = bool((wanted >= _GROUND_PIXELS_MIN).any())
        return np.repeat(empty, len(blind) // sectors), is_due


def unseen_sectors(seen: NDArray[np.bool_], heading_rad: float) -> NDArray[np.float64]:
    """(k, 2) bearings [from, to) outside the `seen` sectors (360,) ahead; from < to, split at south."""
    change = np.diff(seen.astype(np.int8), prepend=0, append=0)
    starts, ends = _EDGES_RAD[np.flatnonzero(change > 0)], _EDGES_RAD[np.flatnonzero(change < 0)]
    if not len(starts):
        return WHOLE_CIRCLE.copy()
    out: list[tuple[float, float]] = []
    for gap_from, gap_to in zip(ends, np.append(starts[1:], starts[0] + 2 * math.pi), strict=True):
        start = _wrapped(heading_rad + gap_from)
        end = start + gap_to - gap_from
        if end <= math.pi:
            out.append((start, end))
        else:
            out.extend([(start, math.pi), (-math.pi, end - 2 * math.pi)])
    return np.array(sorted(pair for pair in out if pair[1] > pair[0]))


def is_seen(seen: NDArray[np.bool_], bearing_rad: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether bearings relative to the camera's heading, in [-pi, pi], lie in a seen sector."""
    sector = np.floor((bearing_rad + math.pi / 2) / (math.pi / len(seen))).astype(np.intp)
    inside = (sector >= 0) & (sector < len(seen))
    return inside & seen[np.clip(sector, 0, len(seen) - 1)]


def _wrapped(angle_rad: float) -> float:
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi
