"""The left half of the picture: the depth image with the discs stood up in it."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.types import Intrinsics
from perception.view.lettering import BLACK, WHITE, Labels, Picture, text_width_px, write
from perception.view.palette import REMEMBERED_AGE_S, disc_colour
from perception.view.shot import Shot, gap_m

PANEL_HEIGHT_PX = 480
_WIDTH_MIN_PX, _WIDTH_MAX_PX = 320, 1280
_NO_RETURN = (0, 0, 0)
_BEYOND_RANGE = (70, 70, 70)
_BLIND_STRIP = (150, 150, 150)
_CIRCLE_STEPS = 24
_NEAR_PLANE_M = 0.1
_EDGE_PX = 4000
_BAR_WIDTH_PX = 128
_STRIP_HEIGHT_PX = 10
LABELS_MAX = 16
"""The nearest discs get labels; more would hide the picture."""


def draw_depth_panel(shot: Shot, *, band_m: float, range_max_m: float, view_range_m: float) -> Picture:
    """BGR, 480 px high: depth in colours from near (red) to `view_range_m` (blue), black where nothing returned, grey beyond
    `range_max_m`.

    Discs are as high as the height band; nearer ones hide further ones. The strip below the image shows unseen bearings.
    """
    depth = np.atleast_2d(np.squeeze(shot.frame.depth))
    scale, (left, top), panel = _fitted(_coloured(depth, shot.frame.depth_unit_m, range_max_m, view_range_m))
    bare = panel.copy()
    labels = Labels(panel)
    _draw_range_bar(panel, labels, view_range_m)
    order = np.argsort([gap_m(disc, shot.camera) for disc in shot.obstacles.discs], kind="stable")
    boxes = {
        int(i): _box(shot.obstacles.discs[i], shot.camera, shot.frame.intrinsics, shot.pose.position_ned_m[2], band_m, scale)
        for i in order
    }
    for i in order[::-1]:
        if (box := boxes[int(i)]) is not None:
            low, high = (box[0] + left, box[1] + top), (box[2] + left, box[3] + top)
            _draw_box(panel, bare, low, high, disc_colour(float(shot.obstacles.age_s[i])))
    for i in order[:LABELS_MAX]:
        if (box := boxes[int(i)]) is not None:
            _label(
                labels,
                panel,
                box,
                (left, top),
                f"{i + 1}: {gap_m(shot.obstacles.discs[i], shot.camera):.1f} m",
                float(shot.obstacles.age_s[i]),
            )
    _draw_unseen_strip(panel, shot, scale, left)
    return panel


def _coloured(depth: NDArray[np.uint16], unit_m: float, range_max_m: float, view_range_m: float) -> Picture:
    depth_m = depth.astype(np.float32) * np.float32(unit_m)
    near_is_warm = np.clip(255 * (1 - depth_m / view_range_m), 0, 255).astype(np.uint8)
    picture: Picture = cv2.applyColorMap(near_is_warm, cv2.COLORMAP_TURBO)
    picture[depth_m > range_max_m] = _BEYOND_RANGE
    picture[depth == 0] = _NO_RETURN
    return picture


def _fitted(image: Picture) -> tuple[float, tuple[int, int], Picture]:
    """Scale, left and top margin, and the image scaled and centred in a panel of a size that video encoders take."""
    height, width = image.shape[:2]
    scale = min(PANEL_HEIGHT_PX / height, _WIDTH_MAX_PX / width)
    scaled_width, scaled_height = max(1, round(width * scale)), max(1, round(height * scale))
    panel_width = min(max(math.ceil(scaled_width / 16) * 16, _WIDTH_MIN_PX), _WIDTH_MAX_PX)
    left, top = (panel_width - scaled_width) // 2, (PANEL_HEIGHT_PX - scaled_height) // 2
    if scale != 1:
        image = cv2.resize(image, (scaled_width, scaled_height), interpolation=cv2.INTER_NEAREST).astype(np.uint8)
    panel = np.full((PANEL_HEIGHT_PX, panel_width, 3), 30, np.uint8)
    panel[top : top + scaled_height, left : left + scaled_width] = image
    return scale, (left, top), panel


def _box(
    disc: NDArray[np.float64], camera: CameraPose, k: Intrinsics, vehicle_down_m: float, band_m: float, scale: float
) -> tuple[int, int, int, int] | None:
    """Left, top, right, bottom in pixels of the scaled image; None if the disc is not in it."""
    angle = np.arange(_CIRCLE_STEPS) * (2 * math.pi / _CIRCLE_STEPS)
    rim_n, rim_e = disc[0] + disc[2] * np.cos(angle), disc[1] + disc[2] * np.sin(angle)
    rim = [np.column_stack([rim_n, rim_e, np.full(_CIRCLE_STEPS, vehicle_down_m + down)]) for down in (-band_m, band_m)]
    optical = (np.concatenate(rim) - camera.position_ned_m) @ camera.rotation
    optical = optical[optical[:, 2] > _NEAR_PLANE_M]
    if not len(optical):
        return None
    u = np.clip(scale * (k.fx_px * optical[:, 0] / optical[:, 2] + k.cx_px), -_EDGE_PX, _EDGE_PX)
    v = np.clip(scale * (k.fy_px * optical[:, 1] / optical[:, 2] + k.cy_px), -_EDGE_PX, _EDGE_PX)
    left, right, top, bottom = int(u.min()), int(u.max()), int(v.min()), int(v.max())
    if right < 0 or bottom < 0 or left >= scale * k.width_px or top >= scale * k.height_px:
        return None
    return left, top, right, bottom


def _draw_box(panel: Picture, bare: Picture, low: tuple[int, int], high: tuple[int, int], colour: tuple[int, int, int]) -> None:
    rows, columns = slice(max(low[1], 0), max(high[1], 0)), slice(max(low[0], 0), max(high[0], 0))
    panel[rows, columns] = bare[rows, columns]
    cv2.rectangle(panel, (low[0] - 1, low[1] - 1), (high[0] + 1, high[1] + 1), BLACK, 1)
    cv2.rectangle(panel, low, high, WHITE, 1)
    cv2.line(panel, low, (high[0], low[1]), colour, 3)


def _label(
    labels: Labels, panel: Picture, box: tuple[int, int, int, int], margin: tuple[int, int], text: str, age_s: float
) -> None:
    """At the top of the box, or further up and tied to it by a line where others are in the way."""
    half = text_width_px(text) // 2 + 6
    x = min(max((box[0] + box[2]) // 2 + margin[0], half), panel.shape[1] - half)
    y = min(max(box[1] + margin[1], 12), panel.shape[0] - 24)
    offsets = [(dx, dy) for dy in (-12, *range(10, 120, 18), *range(-30, -260, -18)) for dx in (0, -30, 30, -60, 60)]
    labels.put(text, (x, y), offsets, WHITE, BLACK if age_s <= REMEMBERED_AGE_S else disc_colour(age_s))


def _draw_range_bar(panel: Picture, labels: Labels, view_range_m: float) -> None:
    """What the colours mean, at the upper left."""
    near, far = "0", f"{view_range_m:g} m"
    width = 8 + text_width_px(near) + 6 + _BAR_WIDTH_PX + 6 + text_width_px(far) + 6
    cv2.rectangle(panel, (0, 0), (width, 20), BLACK, -1)
    labels.reserve((0, 0), (width, 21))
    write(panel, near, (6, 15), WHITE)
    left = 8 + text_width_px(near) + 4
    ramp = np.tile(np.linspace(255, 0, _BAR_WIDTH_PX).astype(np.uint8), (10, 1))
    panel[5:15, left : left + _BAR_WIDTH_PX] = cv2.applyColorMap(ramp, cv2.COLORMAP_TURBO)
    write(panel, far, (left + _BAR_WIDTH_PX + 6, 15), WHITE)


def _draw_unseen_strip(panel: Picture, shot: Shot, scale: float, left: int) -> None:
    """A strip along the lower edge, hatched over the bearings that are reported as unseen."""
    k = shot.frame.intrinsics
    columns = (np.arange(panel.shape[1]) - left) / scale
    inside = (columns >= 0) & (columns < k.width_px)
    rays = np.column_stack([(columns - k.cx_px) / k.fx_px, np.zeros(len(columns)), np.ones(len(columns))])
    mission = rays @ shot.camera.rotation.T
    bearing = np.arctan2(mission[:, 1], mission[:, 0])
    unseen = np.zeros(len(columns), np.bool_)
    for start, end in shot.obstacles.unseen:
        unseen |= np.mod(bearing - start, 2 * math.pi) < end - start
    strip = panel[-_STRIP_HEIGHT_PX:]
    strip[:, inside & ~unseen] = (40, 110, 40)
    strip[:, inside & unseen] = _BLIND_STRIP
    rows, all_columns = np.indices(strip.shape[:2])
    strip[((rows + all_columns) % 8 < 2) & (inside & unseen)[all_columns]] = BLACK
