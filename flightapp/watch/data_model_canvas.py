"""A small drawing of braille characters: every character cell is 2 dots wide and 4 high, and a terminal makes the dots square."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from enum import IntEnum
from itertools import groupby, pairwise

DOTS_ACROSS, DOTS_DOWN = 2, 4
_BRAILLE = 0x2800
_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""By row and column of the dot."""

Dot = tuple[float, float]
"""Across and down from the upper left corner, in dots."""


class Ink(IntEnum):
    """What a cell shows; where several things meet in one cell it is coloured as the greatest."""

    NOTHING = 0
    FENCE = 1
    OBSTACLE = 2
    BOUNDARY = 3
    GOAL = 4
    PURSUER = 5
    EVADER = 6
    LOST = 7


Span = tuple[str, Ink]


class Canvas:
    """`columns` by `rows` characters. What lies outside is left out."""

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self._dots = [[0] * columns for _ in range(rows)]
        self._text = [[""] * columns for _ in range(rows)]
        self._ink = [[Ink.NOTHING] * columns for _ in range(rows)]

    def dot(self, place: Dot, ink: Ink) -> None:
        across, down = math.floor(place[0]), math.floor(place[1])
        column, row = across // DOTS_ACROSS, down // DOTS_DOWN
        if 0 <= column < self.columns and 0 <= row < self.rows:
            self._dots[row][column] |= _BITS[down % DOTS_DOWN][across % DOTS_ACROSS]
            self._ink[row][column] = max(self._ink[row][column], ink)

    def line(self, start: Dot, end: Dot, ink: Ink, every: int = 1) -> None:
        """Straight; `every`: only each so-maniest dot, which tells lines apart where there is no colour."""
        (a, b), (c, d) = start, end
        steps = min(max(1, math.ceil(max(abs(c - a), abs(d - b)))), 4 * (self.columns * DOTS_ACROSS + self.rows * DOTS_DOWN))
        for step in range(0, steps + 1, every):
            share = step / steps
            self.dot((a + (c - a) * share, b + (d - b) * share), ink)

    def path(self, corners: Sequence[Dot], ink: Ink, every: int = 1) -> None:
        for start, end in pairwise(corners):
            self.line(start, end, ink, every)

    def text(self, place: Dot, text: str, ink: Ink) -> None:
        """`text` begins in the cell of the dot `place`, over whatever is drawn there; at the edge it is moved inside."""
        row = min(max(math.floor(place[1]) // DOTS_DOWN, 0), self.rows - 1)
        first = min(max(math.floor(place[0]) // DOTS_ACROSS, 0), max(0, self.columns - len(text)))
        for column, character in enumerate(text[: self.columns], first):
            self._text[row][column], self._ink[row][column] = character, ink

    def lines(self) -> list[list[Span]]:
        """Row by row: runs of characters of one ink."""
        return [
            [("".join(character for character, _ in run), ink) for ink, run in _runs(self._cells(row))]
            for row in range(self.rows)
        ]

    def plain(self) -> list[str]:
        """Row by row, without colours."""
        return ["".join(text for text, _ in line) for line in self.lines()]

    def _cells(self, row: int) -> Iterable[Span]:
        for text, dots, ink in zip(self._text[row], self._dots[row], self._ink[row], strict=True):
            yield text or (chr(_BRAILLE + dots) if dots else " "), ink


def _runs(cells: Iterable[Span]) -> Iterable[tuple[Ink, list[Span]]]:
    for ink, run in groupby(cells, key=lambda cell: cell[1]):
        yield ink, list(run)
