"""The right half of the picture: vehicle, field of view, unseen sectors and discs from above, the camera's heading up."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from perception.view.depth_panel import LABELS_MAX, PANEL_HEIGHT_PX
from perception.view.lettering import BLACK, Colour, Labels, Picture, text_width_px, write
from perception.view.palette import EXCLUDED, REMEMBERED, REMEMBERED_AGE_S, SEEN_NOW, UNSEEN, VEHICLE, VELOCITY, disc_colour
from perception.view.shot import Shot, gap_m

WIDTH_PX = 560
_RING: Colour = (165, 165, 165)
_RING_TEXT: Colour = (110, 110, 110)
_DOT: Colour = (120, 95, 60)
_BEHIND_FRACTION = 0.22
"""Part of the range that is shown behind the camera."""
_LEGEND_HEIGHT_PX = 22
_SPEED_SHOWN_MIN_M_S = 0.15
_SURE_CONFIDENCE = 0.5
_DOT_STEP_PX = 3
_HATCH_STEP_PX = 6


@dataclass(frozen=True, slots=True)
class HeightSlice:
    """Which depth pixels are shown as dots: this much above and below the vehicle, and clear of the ground."""

    band_m: float
    ground_down_m: float
    ground_margin_m: float
    ground_margin_slope: float


def draw_top_view(shot: Shot, height_slice: HeightSlice, *, range_m: float) -> Picture:
    """BGR, 480 x 560 px. range_m: distance ahead at the upper edge."""
    view = _Paper(shot, range_m)
    _draw_unseen(view, shot)
    _draw_rings(view, range_m)
    _draw_field_of_view(view, shot, range_m)
    order = [int(i) for i in np.argsort([gap_m(disc, shot.camera) for disc in shot.obstacles.discs], kind="stable")]
    for i in order[::-1]:
        _shade_disc(view, shot, i)
    _draw_dots(view, shot, height_slice)
    _draw_exclusions(view, shot)
    for i in order[::-1]:
        _outline_disc(view, shot, i)
    _draw_vehicle(view, shot)
    _draw_compass_and_scale(view, shot, range_m)
    for i in order[:LABELS_MAX]:
        _label_disc(view, shot, i)
    _draw_legend(view.picture)
    return view.picture


class _Paper:
    """The empty sheet and the way onto it."""

    def __init__(self, shot: Shot, range_m: float) -> None:
        self.picture: Picture = np.full((PANEL_HEIGHT_PX, WIDTH_PX, 3), 255, np.uint8)
        self.labels = Labels(self.picture)
        height = PANEL_HEIGHT_PX - _LEGEND_HEIGHT_PX
        self.px_per_m = 0.96 * height / (range_m * (1 + _BEHIND_FRACTION))
        self.origin = (WIDTH_PX // 2, round(0.98 * height - _BEHIND_FRACTION * range_m * self.px_per_m))
        self._camera = shot.camera.position_ned_m
        self._cos, self._sin = math.cos(shot.camera.heading_rad), math.sin(shot.camera.heading_rad)

    def pixels(self, north_m: NDArray[np.float64], east_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) x, y."""
        north, east = north_m - self._camera[0], east_m - self._camera[1]
        ahead, aside = north * self._cos + east * self._sin, east * self._cos - north * self._sin
        return np.stack([self.origin[0] + aside * self.px_per_m, self.origin[1] - ahead * self.px_per_m], axis=-1)

    def at(self, north_m: float, east_m: float) -> tuple[int, int]:
        """Whole pixel, clipped to where OpenCV still draws."""
        x, y = np.clip(self.pixels(np.array(north_m), np.array(east_m)), -9999, 9999)
        return round(float(x)), round(float(y))

    def circle(self, disc: NDArray[np.float64]) -> tuple[tuple[int, int], int]:
        """Centre and radius of a disc in pixels; a small one stays visible."""
        radius_px = max(3, min(round(float(disc[2]) * self.px_per_m), 2 * WIDTH_PX))
        return self.at(float(disc[0]), float(disc[1])), radius_px


def _draw_unseen(view: _Paper, shot: Shot) -> None:
    for start, end in shot.obstacles.unseen:
        first, last = (math.degrees(bearing - shot.camera.heading_rad) - 90 for bearing in (start, end))
        cv2.ellipse(view.picture, view.origin, (2 * WIDTH_PX, 2 * WIDTH_PX), 0, first, last, UNSEEN, -1)


def _draw_rings(view: _Paper, range_m: float) -> None:
    step = next(step for step in (0.5, 1, 2, 5, 10, 20) if range_m / step <= 6 or step == 20)
    for number in range(1, int(range_m / step + 1e-6) + 1):
        radius = round(number * step * view.px_per_m)
        cv2.circle(view.picture, view.origin, radius, _RING, 1, cv2.LINE_AA)
        text, y = f"{number * step:g} m", view.origin[1] - radius
        left = view.origin[0] + 4
        write(view.picture, text, (left, y + 14), _RING_TEXT)
        view.labels.reserve((left - 1, y + 2), (left + text_width_px(text) + 1, y + 17))


def _draw_field_of_view(view: _Paper, shot: Shot, range_m: float) -> None:
    k = shot.frame.intrinsics
    for edge_px in (0.0, float(k.width_px)):
        ray = shot.camera.level @ np.array([(edge_px - k.cx_px) / k.fx_px, 0.0, 1.0])
        angle = math.atan2(ray[1], ray[0])
        end = (
            round(view.origin[0] + range_m * view.px_per_m * math.sin(angle)),
            round(view.origin[1] - range_m * view.px_per_m * math.cos(angle)),
        )
        cv2.line(view.picture, view.origin, end, (120, 120, 120), 1, cv2.LINE_AA)


def _draw_dots(view: _Paper, shot: Shot, height_slice: HeightSlice) -> None:
    """The depth pixels from which the discs come."""
    points = _points_in_slice(shot, height_slice)
    x, y = np.rint(view.pixels(points[:, 0], points[:, 1])).astype(np.int64).T
    inside = (x >= 0) & (x < view.picture.shape[1]) & (y >= 0) & (y < view.picture.shape[0])
    view.picture[y[inside], x[inside]] = _DOT


def _points_in_slice(shot: Shot, height_slice: HeightSlice) -> NDArray[np.float64]:
    """(n, 3) north, east, down of every third row's and column's depth pixel that a vehicle at this height could hit."""
    k = shot.frame.intrinsics
    if shot.frame.depth.shape != (k.height_px, k.width_px):
        return np.zeros((0, 3))
    sample = shot.frame.depth[::_DOT_STEP_PX, ::_DOT_STEP_PX]
    v, u = np.nonzero(sample)
    z = sample[v, u] * shot.frame.depth_unit_m
    optical = np.column_stack([(u * _DOT_STEP_PX - k.cx_px) / k.fx_px * z, (v * _DOT_STEP_PX - k.cy_px) / k.fy_px * z, z])
    points = optical @ shot.camera.rotation.T + shot.camera.position_ned_m
    margin_m = height_slice.ground_margin_m + height_slice.ground_margin_slope * z
    off_vehicle_m = np.abs(points[:, 2] - shot.pose.position_ned_m[2])
    kept: NDArray[np.float64] = points[
        (off_vehicle_m <= height_slice.band_m) & (points[:, 2] < height_slice.ground_down_m - margin_m)
    ]
    return kept


def _draw_exclusions(view: _Paper, shot: Shot) -> None:
    for north, east, radius in shot.exclude:
        centre, radius_px = view.at(north, east), max(4, round(radius * view.px_per_m))
        for start in range(0, 360, 24):
            cv2.ellipse(view.picture, centre, (radius_px, radius_px), 0, start, start + 14, EXCLUDED, 2, cv2.LINE_AA)
        cv2.drawMarker(view.picture, centre, EXCLUDED, cv2.MARKER_CROSS, 8, 1)


def _shade_disc(view: _Paper, shot: Shot, i: int) -> None:
    """Filled if seen now, hatched if remembered; the paler the less sure it is."""
    age_s, confidence = float(shot.obstacles.age_s[i]), float(shot.obstacles.confidence[i])
    strength = 0.08 + 0.3 * min(max(confidence, 0.0), 1.0)
    _fill_disc(view.picture, *view.circle(shot.obstacles.discs[i]), disc_colour(age_s), strength, age_s > REMEMBERED_AGE_S)


def _outline_disc(view: _Paper, shot: Shot, i: int) -> None:
    """Thin where it is not sure that something is there; with an arrow if it moves."""
    centre, radius_px = view.circle(shot.obstacles.discs[i])
    thickness = 2 if shot.obstacles.confidence[i] >= _SURE_CONFIDENCE else 1
    cv2.circle(view.picture, centre, radius_px, disc_colour(float(shot.obstacles.age_s[i])), thickness, cv2.LINE_AA)
    view.labels.mark_circle(centre, radius_px)
    north, east, _, speed_n, speed_e = (float(number) for number in shot.obstacles.discs[i, :5])
    if math.hypot(speed_n, speed_e) >= _SPEED_SHOWN_MIN_M_S:
        cv2.arrowedLine(view.picture, centre, view.at(north + speed_n, east + speed_e), VELOCITY, 2, cv2.LINE_AA, 0, 0.25)


def _fill_disc(picture: Picture, centre: tuple[int, int], radius_px: int, colour: Colour, strength: float, hatched: bool) -> None:
    left, top = max(centre[0] - radius_px, 0), max(centre[1] - radius_px, 0)
    part = picture[top : max(centre[1] + radius_px + 1, 0), left : max(centre[0] + radius_px + 1, 0)]
    if not part.size:
        return
    y, x = np.mgrid[top : top + part.shape[0], left : left + part.shape[1]]
    inside = (x - centre[0]) ** 2 + (y - centre[1]) ** 2 <= radius_px**2
    if hatched:
        inside &= (x + y) % _HATCH_STEP_PX < 2
        strength = 0.4 + strength
    mixed = (1 - strength) * part[inside] + strength * np.array(colour)
    part[inside] = mixed.astype(np.uint8)


def _label_disc(view: _Paper, shot: Shot, i: int) -> None:
    """Number and distance beside the disc."""
    disc = shot.obstacles.discs[i]
    text = f"{i + 1}: {gap_m(disc, shot.camera):.1f} m"
    centre = view.at(float(disc[0]), float(disc[1]))
    if not (0 <= centre[0] < WIDTH_PX and 0 <= centre[1] < PANEL_HEIGHT_PX):
        return
    radius_px, half = round(float(disc[2]) * view.px_per_m), text_width_px(text) // 2 + 4
    aside, above = radius_px + half + 3, radius_px + 12
    outward = 1 if centre[0] >= view.origin[0] else -1
    offsets = [
        (round(x * grow), round(y * grow))
        for grow in (1.0, 1.5, 2.1)
        for x, y in (
            (outward * aside, 0),
            (-outward * aside, 0),
            (0, -above),
            (0, above),
            (outward * aside, -above),
            (outward * aside, above),
            (-outward * aside, -above),
            (-outward * aside, above),
        )
    ]
    view.labels.put(text, centre, offsets, BLACK, None)


def _draw_vehicle(view: _Paper, shot: Shot) -> None:
    """An arrow head at the vehicle's place, along its heading."""
    x, y = view.at(shot.pose.position_ned_m[0], shot.pose.position_ned_m[1])
    turn = shot.pose.yaw_rad - shot.camera.heading_rad if math.isfinite(shot.pose.yaw_rad) else 0.0
    cos, sin = math.cos(turn), math.sin(turn)
    outline = [(0, -11), (8, 9), (0, 4), (-8, 9)]
    corners = np.array([[x + cos * dx - sin * dy, y + sin * dx + cos * dy] for dx, dy in outline])
    cv2.fillPoly(view.picture, [np.rint(corners).astype(np.int32)], VEHICLE, cv2.LINE_AA)
    view.labels.reserve((x - 10, y - 12), (x + 10, y + 12))


def _draw_compass_and_scale(view: _Paper, shot: Shot, range_m: float) -> None:
    """Where north is, at the upper right; a scale bar at the lower right."""
    at, length = (WIDTH_PX - 26, 28), 16
    sin, cos = math.sin(-shot.camera.heading_rad), math.cos(-shot.camera.heading_rad)
    tip, tail = ((round(at[0] + sign * length * sin), round(at[1] - sign * length * cos)) for sign in (1, -1))
    cv2.arrowedLine(view.picture, tail, tip, BLACK, 1, cv2.LINE_AA, 0, 0.3)
    write(view.picture, "N", (at[0] + 5, at[1] + 5), BLACK)
    view.labels.reserve((at[0] - 25, 0), (WIDTH_PX, at[1] + 26))
    bar_m = 1.0 if range_m <= 15 else 5.0
    right, y = WIDTH_PX - 14, PANEL_HEIGHT_PX - _LEGEND_HEIGHT_PX - 12
    left = right - round(bar_m * view.px_per_m)
    text = f"{bar_m:g} m"
    cv2.line(view.picture, (left, y), (right, y), BLACK, 2)
    for x in (left, right):
        cv2.line(view.picture, (x, y - 4), (x, y + 4), BLACK, 2)
    write(view.picture, text, ((left + right - text_width_px(text)) // 2, y - 8), BLACK)
    view.labels.reserve((left - 6, y - 24), (WIDTH_PX, PANEL_HEIGHT_PX))


def _draw_legend(picture: Picture) -> None:
    """One line that says what the marks mean."""
    top = PANEL_HEIGHT_PX - _LEGEND_HEIGHT_PX
    picture[top:] = 255
    cv2.line(picture, (0, top), (WIDTH_PX, top), _RING, 1)
    middle, x = top + _LEGEND_HEIGHT_PX // 2, 14
    for colour, name in ((SEEN_NOW, "seen now"), (REMEMBERED, "remembered")):
        _fill_disc(picture, (x, middle), 6, colour, 0.5, colour is REMEMBERED)
        cv2.circle(picture, (x, middle), 6, colour, 2, cv2.LINE_AA)
        x = _legend_text(picture, name, x + 11, middle)
    cv2.arrowedLine(picture, (x - 6, middle), (x + 12, middle), VELOCITY, 2, cv2.LINE_AA, 0, 0.35)
    x = _legend_text(picture, "1 s of travel", x + 17, middle)
    cv2.circle(picture, (x, middle), 6, EXCLUDED, 2, cv2.LINE_AA)
    x = _legend_text(picture, "excluded", x + 11, middle)
    picture[middle - 6 : middle + 7, x - 6 : x + 10] = UNSEEN
    x = _legend_text(picture, "not seen", x + 15, middle)
    for dx, dy in ((-4, -3), (0, 2), (4, -1), (-2, 4), (3, 4), (1, -4)):
        picture[middle + dy : middle + dy + 2, x + dx : x + dx + 2] = _DOT
    _legend_text(picture, "depth", x + 10, middle)


def _legend_text(picture: Picture, text: str, x: int, middle: int) -> int:
    """Where the next mark goes."""
    write(picture, text, (x, middle + 5), BLACK)
    return x + text_width_px(text) + 20
