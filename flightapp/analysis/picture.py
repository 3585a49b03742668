"""map.png: the map of a run as a plain picture, for a README or a terminal without a browser."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from flightapp.analysis.map_data import INK, OTHER_LABEL, MapData, Marker, map_data
from flightapp.analysis.run import Run, load_run
from flightapp.analysis.summary import write_whole
from flightapp.core.types import Array

Image = NDArray[np.uint8]
_SIDE_PX = 1000
_LEFT_PX, _TOP_PX, _BOTTOM_PX, _LEGEND_PX = 80, 30, 70, 300
_GRID, _FENCE, _RED, _STONE, _AMBER = "#e4e7eb", "#52606d", "#b42318", "#616e7c", "#d97706"
_KNOWN, _WAY = "#8a3ffc", "#0b7285"
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_SHIFT = 4  # fractional bits of drawing coordinates


def write_picture(run: Path) -> Path:
    """Write `map.png` into the run folder; InputError if it holds no readable recording."""
    return save_picture(load_run([run]))


def save_picture(run: Run) -> Path:
    """Write the picture where it belongs; whole or not at all."""
    path = run.output("map.png")
    _, data = cv2.imencode(".png", draw_map(map_data(run)))
    write_whole(path, data.tobytes())
    return path


def draw_map(data: MapData) -> Image:
    """The map as a BGR image (rows, columns, 3), north up, equal axes."""
    return _Canvas(data).draw()


class _Canvas:
    def __init__(self, data: MapData) -> None:
        self._data = data
        height_m, width_m = data.high_m[0] - data.low_m[0], data.high_m[1] - data.low_m[1]
        self._scale = _SIDE_PX / max(height_m, width_m)
        self._rows, self._columns = round(height_m * self._scale), round(width_m * self._scale)
        shape = (self._rows + _TOP_PX + _BOTTOM_PX, self._columns + _LEFT_PX + _LEGEND_PX, 3)
        self._image: Image = np.full(shape, 255, dtype=np.uint8)

    def draw(self) -> Image:
        data = self._data
        self._axes()
        self._fill(data.obstacles, _STONE, 0.25)
        self._fill(data.known, _KNOWN, 0.12)
        self._fill(data.perceived, _AMBER, 0.22)
        if data.fence is not None:
            self._dashed(data.fence, _FENCE)
        if data.boundary is not None:
            self._line(data.boundary, _RED, 3)
        for way in data.ways:
            self._dashed(way, _WAY)
        for stretch in sorted(data.stretches, key=lambda one: one.label != OTHER_LABEL):
            self._line(stretch.points_m, stretch.colour, 1 if stretch.label == OTHER_LABEL else 3)
        for marker in data.markers:
            self._marker(marker)
        self._legend()
        return self._image

    def _pixels(self, points_m: Array) -> NDArray[np.int32]:
        """(n, 2) north, east -> (n, 1, 2) column, row with fractional bits."""
        column = _LEFT_PX + (points_m[:, 1] - self._data.low_m[1]) * self._scale
        row = _TOP_PX + (self._data.high_m[0] - points_m[:, 0]) * self._scale
        return np.round(np.column_stack([column, row]) * (1 << _SHIFT)).astype(np.int32).reshape(-1, 1, 2)

    def _line(self, points_m: Array, colour: str, width: int) -> None:
        cv2.polylines(self._image, [self._pixels(points_m)], False, _bgr(colour), width, cv2.LINE_AA, _SHIFT)

    def _dashed(self, points_m: Array, colour: str) -> None:
        for start, end in itertools.pairwise(points_m):
            count = max(1, int(np.linalg.norm(end - start) * self._scale / 14))
            for index in range(count):
                part = np.array([start + (end - start) * share for share in (index / count, (index + 0.5) / count)])
                self._line(part, colour, 1)

    def _fill(self, outlines: tuple[Array, ...], colour: str, opacity: float) -> None:
        overlay = self._image.copy()
        for outline in outlines:
            cv2.fillPoly(overlay, [self._pixels(outline)], _bgr(colour), cv2.LINE_AA, _SHIFT)
        self._image[:] = cv2.addWeighted(overlay, opacity, self._image, 1.0 - opacity, 0.0)
        for outline in outlines:
            self._line(outline, colour, 1)

    def _axes(self) -> None:
        step_m = _round_step(max(self._data.high_m[0] - self._data.low_m[0], self._data.high_m[1] - self._data.low_m[1]) / 9)
        right, bottom = _LEFT_PX + self._columns, _TOP_PX + self._rows
        for north_m in _ticks(self._data.low_m[0], self._data.high_m[0], step_m):
            row = round(_TOP_PX + (self._data.high_m[0] - north_m) * self._scale)
            cv2.line(self._image, (_LEFT_PX, row), (right, row), _bgr(_GRID), 1)
            self._text(f"{north_m:g}", (_LEFT_PX - 10, row + 5), align=1.0)
        for east_m in _ticks(self._data.low_m[1], self._data.high_m[1], step_m):
            column = round(_LEFT_PX + (east_m - self._data.low_m[1]) * self._scale)
            cv2.line(self._image, (column, _TOP_PX), (column, bottom), _bgr(_GRID), 1)
            self._text(f"{east_m:g}", (column, bottom + 22), align=0.5)
        cv2.rectangle(self._image, (_LEFT_PX, _TOP_PX), (right, bottom), _bgr("#9aa5b1"), 1)
        self._text("east, m", (_LEFT_PX + self._columns // 2, bottom + 52), align=0.5)
        self._text("north, m", (_LEFT_PX - 10, _TOP_PX - 10), align=0.5)

    def _marker(self, marker: Marker) -> None:
        column, row = (self._pixels(np.array([marker.point_m]))[0, 0] >> _SHIFT).tolist()
        colour = marker.colour
        if marker.kind == "capture":
            cv2.drawMarker(self._image, (column, row), _bgr("#ffffff"), cv2.MARKER_STAR, 26, 6, cv2.LINE_AA)
            cv2.drawMarker(self._image, (column, row), _bgr(colour), cv2.MARKER_STAR, 22, 2, cv2.LINE_AA)
            end = (column + 70, row - 50)
            cv2.line(self._image, (column + 12, row - 9), end, _bgr(colour), 1, cv2.LINE_AA)
            self._text(marker.text, (end[0] + 4, end[1]), colour=colour, halo=True)
        else:
            cv2.circle(self._image, (column, row), 7, _bgr("#ffffff"), cv2.FILLED, cv2.LINE_AA)
            cv2.circle(self._image, (column, row), 5, _bgr(colour), cv2.FILLED, cv2.LINE_AA)
            below = -14 if marker.label_above else 24
            self._text(marker.text, (column, row + below), align=0.5, colour=colour, halo=True)

    def _legend(self) -> None:
        data = self._data
        entries = list(dict.fromkeys((stretch.label, stretch.colour) for stretch in data.stretches))
        entries += [("protected boundary", _RED)] if data.boundary is not None else []
        entries += [("fence", _FENCE)] if data.fence is not None else []
        entries += [("surveyed obstacle", _STONE)] if data.obstacles else []
        entries += [("known obstacle", _KNOWN)] if data.known else []
        entries += [("way as planned", _WAY)] if data.ways else []
        entries += [("obstacle as perceived", _AMBER)] if data.perceived else []
        column = _LEFT_PX + self._columns + 20
        for number, (label, colour) in enumerate(entries):
            row = _TOP_PX + 16 + 26 * number
            cv2.line(self._image, (column, row), (column + 24, row), _bgr(colour), 3, cv2.LINE_AA)
            self._text(label, (column + 34, row + 5))

    def _text(self, text: str, at: tuple[int, int], *, align: float = 0.0, colour: str = INK, halo: bool = False) -> None:
        (width, _), _ = cv2.getTextSize(text, _FONT, 0.5, 1)
        where = (at[0] - round(align * width), at[1])
        if halo:
            cv2.putText(self._image, text, where, _FONT, 0.5, _bgr("#ffffff"), 5, cv2.LINE_AA)
        cv2.putText(self._image, text, where, _FONT, 0.5, _bgr(colour), 1, cv2.LINE_AA)


def _bgr(colour: str) -> tuple[int, int, int]:
    return int(colour[5:7], 16), int(colour[3:5], 16), int(colour[1:3], 16)


def _round_step(least: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not below `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least)


def _ticks(low: float, high: float, step: float) -> list[float]:
    return [index * step for index in range(math.ceil(low / step), math.floor(high / step) + 1)]
