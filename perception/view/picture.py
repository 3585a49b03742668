"""One picture of one frame: depth image left, top view right, three lines of text below."""

from __future__ import annotations

import math

import cv2
import numpy as np

from perception.view.depth_panel import draw_depth_panel
from perception.view.lettering import WHITE, Colour, Picture, shortened, write
from perception.view.palette import WARNING
from perception.view.shot import Shot, gap_m, off_axis_rad
from perception.view.top_view import HeightSlice, draw_top_view

_LINE_PX, _LINES = 20, 3
_STRIP_HEIGHT_PX = 64
_QUIET: Colour = (170, 170, 170)


def draw(shot: Shot, height_slice: HeightSlice, *, range_max_m: float, view_range_m: float) -> Picture:
    """BGR, 544 px high; the width follows from the shape of the depth image. view_range_m: how far colours and top view reach."""
    left = draw_depth_panel(shot, band_m=height_slice.band_m, range_max_m=range_max_m, view_range_m=view_range_m)
    right = draw_top_view(shot, height_slice, range_m=view_range_m)
    strip = np.full((_STRIP_HEIGHT_PX, left.shape[1] + right.shape[1], 3), 30, np.uint8)
    picture = np.concatenate([np.concatenate([left, right], axis=1), strip])
    _write_lines(picture, [(_summary(shot), WHITE), (health_line(shot), _QUIET), _events(shot)])
    return picture


def with_notice(picture: Picture, notice: str) -> Picture:
    """A copy with the events' line replaced: for what happens while no frame comes."""
    copy = picture.copy()
    copy[-_STRIP_HEIGHT_PX + (_LINES - 1) * _LINE_PX + 4 :] = 30
    _write_line(copy, _LINES - 1, f"! {notice}", WARNING)
    return copy


def health_line(shot: Shot) -> str:
    """State of the source and the time that perception takes."""
    timing, health = shot.timing, shot.health
    parts = [f"{timing.rate_hz:.1f} Hz" if math.isfinite(timing.rate_hz) else "- Hz"]
    parts.append(f"computing p50 {1e3 * timing.process_p50_s:.1f}, p99 {1e3 * timing.process_p99_s:.1f} ms")
    if timing.latency_p50_s is not None and timing.latency_p99_s is not None:
        parts.append(f"latency p50 {1e3 * timing.latency_p50_s:.0f}, p99 {1e3 * timing.latency_p99_s:.0f} ms")
    parts.append(f"received {health.received}, lost {health.lost}, skipped {health.skipped}, restarts {health.restarts}")
    if health.temperature_c is not None:
        parts.append(f"{health.temperature_c:.0f} °C")
    return "   ".join(parts)


def _summary(shot: Shot) -> str:
    discs = shot.obstacles.discs
    found = "no disc" if not len(discs) else "1 disc" if len(discs) == 1 else f"{len(discs)} discs"
    if len(discs):
        nearest = discs[int(np.argmin([gap_m(disc, shot.camera) for disc in discs]))]
        found += f", nearest {gap_m(nearest, shot.camera):.2f} m at {math.degrees(off_axis_rad(nearest, shot.camera)):+.0f}°"
    unseen_deg = math.degrees(sum(float(end - start) for start, end in shot.obstacles.unseen))
    return f"{shot.name}   t {shot.frame.t_s:.2f} s   {found}   not seen {unseen_deg:.0f}° of 360°"


def _events(shot: Shot) -> tuple[str, Colour]:
    events = [*shot.obstacles.events, *([shot.health.fault] if shot.health.fault else [])]
    return (f"! {'; '.join(events)}", WARNING) if events else ("no events", _QUIET)


def _write_lines(picture: Picture, lines: list[tuple[str, Colour]]) -> None:
    cv2.line(
        picture, (0, picture.shape[0] - _STRIP_HEIGHT_PX), (picture.shape[1], picture.shape[0] - _STRIP_HEIGHT_PX), _QUIET, 1
    )
    for number, (text, colour) in enumerate(lines):
        _write_line(picture, number, text, colour)


def _write_line(picture: Picture, number: int, text: str, colour: Colour) -> None:
    y = picture.shape[0] - _STRIP_HEIGHT_PX + 18 + number * _LINE_PX
    write(picture, shortened(text, picture.shape[1] - 16), (8, y), colour)
