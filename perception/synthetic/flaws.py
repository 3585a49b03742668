"""What spoils the pictures of a depth camera in the field, beyond the noise that every picture has."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.types import Intrinsics

_HALO = 1.5
"""Around a glare the returns come back gradually, up to this many radii from its centre."""
_SPECKLE_PX = (2, 7)


@dataclass(frozen=True, slots=True)
class Glare:
    """A round part of the picture without return: a lamp, a reflection on water."""

    u_px: float
    v_px: float
    radius_px: float = 60.0


@dataclass(frozen=True, slots=True)
class Sun:
    """Glare around a direction in the mission frame; none while it is out of the picture.

    bearing_rad: clockwise from north. radius_px: 60 px are 8 degrees at the centre of a D435's picture.
    """

    bearing_rad: float
    elevation_rad: float
    radius_px: float = 60.0


@dataclass(frozen=True, slots=True)
class Cover:
    """Something on the lens: a rectangle, in fractions of the picture, that returns nothing, or `depth_m` if that is not 0."""

    left: float = 0.0
    right: float = 1.0
    top: float = 0.0
    bottom: float = 1.0
    depth_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Flaws:
    """Options of the measurement; the default is a good camera on a good day.

    window_px: matching window, 1 = exact edges. hole_fraction: share of pixels without return within 8 m. speckles: wrong
    matches a frame, blobs of 2 to 6 px at a disparity as good as any.
    """

    window_px: int = 5
    hole_fraction: float = 0.01
    speckles: int = 0
    glare: Glare | Sun | None = None
    cover: Cover | None = None


def spoil(
    depth_mm: NDArray[np.uint16], flaws: Flaws, intrinsics: Intrinsics, camera: CameraPose, random: np.random.Generator
) -> None:
    """Put speckles, glare and cover into a measured image (height, width), in place."""
    if flaws.speckles:
        _speckle(depth_mm, flaws.speckles, random)
    glare = _in_picture(flaws.glare, intrinsics, camera) if isinstance(flaws.glare, Sun) else flaws.glare
    if glare is not None:
        _dazzle(depth_mm, glare, random)
    if flaws.cover is not None:
        height, width = depth_mm.shape
        rows = slice(round(flaws.cover.top * height), round(flaws.cover.bottom * height))
        columns = slice(round(flaws.cover.left * width), round(flaws.cover.right * width))
        depth_mm[rows, columns] = round(flaws.cover.depth_m * 1000)


def _speckle(depth_mm: NDArray[np.uint16], number: int, random: np.random.Generator) -> None:
    height, width = depth_mm.shape
    nearest_m, farthest_m = 0.3, 30.0
    for _ in range(number):
        v, u = int(random.integers(height)), int(random.integers(width))
        rows, columns = (int(size) for size in random.integers(*_SPECKLE_PX, size=2))
        inverse = random.uniform(1 / farthest_m, 1 / nearest_m)
        depth_mm[v : v + rows, u : u + columns] = round(1000 / inverse)


def _in_picture(sun: Sun, intrinsics: Intrinsics, camera: CameraPose) -> Glare | None:
    level = math.cos(sun.elevation_rad)
    direction = np.array([level * math.cos(sun.bearing_rad), level * math.sin(sun.bearing_rad), -math.sin(sun.elevation_rad)])
    x, y, z = (camera.rotation.T @ direction).tolist()
    if z <= 0.0:
        return None
    u, v = intrinsics.cx_px + intrinsics.fx_px * x / z, intrinsics.cy_px + intrinsics.fy_px * y / z
    return Glare(u, v, sun.radius_px)


def _dazzle(depth_mm: NDArray[np.uint16], glare: Glare, random: np.random.Generator) -> None:
    height, width = depth_mm.shape
    reach = _HALO * glare.radius_px
    top, bottom = (min(max(math.floor(glare.v_px + side), 0), height) for side in (-reach, reach + 1))
    left, right = (min(max(math.floor(glare.u_px + side), 0), width) for side in (-reach, reach + 1))
    if top >= bottom or left >= right:
        return
    distance = np.hypot(np.arange(top, bottom)[:, None] - glare.v_px, np.arange(left, right) - glare.u_px) / glare.radius_px
    is_lost = random.random(distance.shape) > (distance - 1.0) / (_HALO - 1.0)
    depth_mm[top:bottom, left:right][is_lost] = 0
