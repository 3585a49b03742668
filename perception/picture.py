"""One picture of what perception made of a depth frame: the depth image with the discs on the left, the top view on the right."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.types import DepthFrame, PerceivedObstacles

Picture = NDArray[np.uint8]

_DISC_COLOUR = (255, 255, 255)
_TOP_DISC_COLOUR = (60, 60, 230)
_RING_COLOUR = (150, 150, 150)
_UNSEEN_COLOUR = (205, 205, 205)
_TEXT_COLOUR = (40, 40, 40)
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_CIRCLE_STEPS = 24


def draw(
    frame: DepthFrame, obstacles: PerceivedObstacles, camera: CameraPose, *, band_m: float, range_max_m: float, title: str
) -> Picture:
    """BGR picture, as high as the depth image: depth with discs, then the top view with the camera's heading up."""
    left = _depth_view(frame, obstacles, camera, band_m, range_max_m)
    right = _top_view(obstacles, camera, range_max_m, left.shape[0])
    picture = np.concatenate([left, right], axis=1)
    lines = [title, *obstacles.events]
    for i, line in enumerate(lines):
        _text(picture, line, (8, 20 + 20 * i), (255, 255, 255))
    return picture


def _depth_view(
    frame: DepthFrame, obstacles: PerceivedObstacles, camera: CameraPose, band_m: float, range_max_m: float
) -> Picture:
    depth_m = frame.depth.astype(np.float32) * np.float32(frame.depth_unit_m)
    near_is_warm = np.clip(255 * (1 - depth_m / range_max_m), 0, 255).astype(np.uint8)
    picture: Picture = cv2.applyColorMap(near_is_warm, cv2.COLORMAP_TURBO)
    picture[frame.depth == 0] = 0
    picture[depth_m > range_max_m] = (60, 60, 60)
    angle = np.arange(_CIRCLE_STEPS) * (2 * math.pi / _CIRCLE_STEPS)
    for number, disc in enumerate(obstacles.discs, start=1):
        rim_n, rim_e = disc[0] + disc[2] * np.cos(angle), disc[1] + disc[2] * np.sin(angle)
        rim = [
            np.column_stack([rim_n, rim_e, np.full(_CIRCLE_STEPS, camera.position_ned_m[2] + down)]) for down in (-band_m, band_m)
        ]
        optical = (np.concatenate(rim) - camera.position_ned_m) @ camera.rotation
        optical = optical[optical[:, 2] > 0.1]
        if not len(optical):
            continue
        k = frame.intrinsics
        u, v = k.fx_px * optical[:, 0] / optical[:, 2] + k.cx_px, k.fy_px * optical[:, 1] / optical[:, 2] + k.cy_px
        edge = 4000
        low = (int(np.clip(u.min(), -edge, edge)), int(np.clip(v.min(), -edge, edge)))
        high = (int(np.clip(u.max(), -edge, edge)), int(np.clip(v.max(), -edge, edge)))
        cv2.rectangle(picture, low, high, _DISC_COLOUR, 1)
        at = (min(max(low[0] + 3, 0), k.width_px - 40), min(max(low[1] + 14, 50), k.height_px - 6))
        _text(picture, f"{number}: {_gap_m(disc, camera):.1f} m", at, _DISC_COLOUR)
    return picture


def _top_view(obstacles: PerceivedObstacles, camera: CameraPose, range_max_m: float, size: int) -> Picture:
    picture = np.full((size, size, 3), 255, np.uint8)
    scale = 0.94 * size / (range_max_m * 1.25)
    origin = (size // 2, round(0.97 * size - 0.25 * range_max_m * scale))
    for start, end in obstacles.unseen:
        first, last = math.degrees(start - camera.heading_rad) - 90, math.degrees(end - camera.heading_rad) - 90
        cv2.ellipse(picture, origin, (2 * size, 2 * size), 0, first, last, _UNSEEN_COLOUR, -1)
    step = 1 if range_max_m <= 6 else 2
    for ring in range(step, int(range_max_m) + 1, step):
        cv2.circle(picture, origin, round(ring * scale), _RING_COLOUR, 1, cv2.LINE_AA)
        _text(picture, f"{ring} m", (origin[0] + 3, origin[1] - round(ring * scale) - 2), _RING_COLOUR)
    cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
    for number, disc in enumerate(obstacles.discs, start=1):
        north, east = disc[0] - camera.position_ned_m[0], disc[1] - camera.position_ned_m[1]
        ahead, aside = north * cos + east * sin, east * cos - north * sin
        centre = (round(origin[0] + aside * scale), round(origin[1] - ahead * scale))
        cv2.circle(picture, centre, max(2, round(disc[2] * scale)), _TOP_DISC_COLOUR, 2, cv2.LINE_AA)
        _text(picture, str(number), (centre[0] - 4, centre[1] + 4), _TEXT_COLOUR)
    cv2.drawMarker(picture, origin, (0, 120, 0), cv2.MARKER_TRIANGLE_UP, 14, 2)
    _text(picture, "grey: not seen", (8, size - 8), _TEXT_COLOUR)
    return picture


def _gap_m(disc: NDArray[np.float64], camera: CameraPose) -> float:
    """Distance from the camera to the front of a disc."""
    return float(math.hypot(disc[0] - camera.position_ned_m[0], disc[1] - camera.position_ned_m[1]) - disc[2])


def _text(picture: Picture, text: str, at: tuple[int, int], colour: tuple[int, int, int]) -> None:
    cv2.putText(picture, text, at, _FONT, 0.42, colour, 1, cv2.LINE_AA)
