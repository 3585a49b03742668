"""Text that can be read at full size, and labels that do not cover each other."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

WHITE: Colour = (255, 255, 255)
BLACK: Colour = (25, 25, 25)
TEXT_SCALE = 0.45
TEXT_HEIGHT_PX = 11
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_PADDING_PX = 3


def text_width_px(text: str) -> int:
    return int(cv2.getTextSize(text, _FONT, TEXT_SCALE, 1)[0][0])


def write(picture: Picture, text: str, at: tuple[int, int], colour: Colour) -> None:
    """at: left end of the base line, in pixels."""
    cv2.putText(picture, text, at, _FONT, TEXT_SCALE, colour, 1, cv2.LINE_AA)


def shortened(text: str, width_px: int) -> str:
    """`text`, cut with an ellipsis to what fits into `width_px`."""
    if text_width_px(text) <= width_px:
        return text
    fitting = len(text)
    while fitting and text_width_px(text[:fitting] + "…") > width_px:
        fitting = min(fitting - 1, int(fitting * width_px / text_width_px(text[:fitting] + "…")))
    return text[:fitting] + "…"


class Labels:
    """Puts labels into a picture where they cover no other label and as little as possible of what is marked as busy."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self._lettered = np.zeros(picture.shape[:2], np.bool_)
        self._busy = np.zeros(picture.shape[:2], np.uint8)

    def mark_circle(self, centre: tuple[int, int], radius_px: int) -> None:
        """What lies in the circle should rather stay visible."""
        cv2.circle(self._busy, centre, radius_px, 1, -1)

    def reserve(self, low: tuple[int, int], high: tuple[int, int]) -> None:
        """No label may go into this rectangle."""
        self._lettered[max(low[1], 0) : max(high[1], 0), max(low[0], 0) : max(high[0], 0)] = True

    def put(
        self, text: str, anchor: tuple[int, int], offsets: Iterable[tuple[int, int]], colour: Colour, paper: Colour | None
    ) -> bool:
        """Letter `text` with its centre at anchor + one of `offsets`, the first of the least busy; False if none is free.

        paper: colour of the background, None for none. A label away from its anchor is tied to it by a thin line.
        """
        width, height = text_width_px(text) + 2 * _PADDING_PX, TEXT_HEIGHT_PX + 2 * _PADDING_PX
        best: tuple[float, int, int] | None = None
        for dx, dy in offsets:
            left, top = anchor[0] + dx - width // 2, anchor[1] + dy - height // 2
            if left < 0 or top < 0 or left + width > self._picture.shape[1] or top + height > self._picture.shape[0]:
                continue
            place = np.s_[top : top + height, left : left + width]
            if self._lettered[place].any():
                continue
            cost = float(self._busy[place].mean())
            if best is None or cost < best[0] - 0.05:
                best = (cost, left, top)
            if cost == 0:
                break
        if best is None:
            return False
        _, left, top = best
        self._lettered[top : top + height, left : left + width] = True
        self._tie(anchor, (left, top), (left + width, top + height), paper or colour)
        if paper is not None:
            cv2.rectangle(self._picture, (left, top), (left + width - 1, top + height - 1), paper, -1)
        write(self._picture, text, (left + _PADDING_PX, top + height - _PADDING_PX), colour)
        return True

    def _tie(self, anchor: tuple[int, int], low: tuple[int, int], high: tuple[int, int], colour: Colour) -> None:
        nearest = (min(max(anchor[0], low[0]), high[0]), min(max(anchor[1], low[1]), high[1]))
        if abs(nearest[0] - anchor[0]) + abs(nearest[1] - anchor[1]) > 2 * TEXT_HEIGHT_PX:
            cv2.line(self._picture, anchor, nearest, colour, 1, cv2.LINE_AA)
