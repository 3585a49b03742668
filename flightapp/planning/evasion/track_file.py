"""Recorded tracks as text: header timestamp,tx,ty,tz,qx,qy,qz,qw; s and m, x east, y north, z up; read for north and east."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from flightapp.core.errors import InputError
from flightapp.core.types import Array

HEADER = "timestamp,tx,ty,tz,qx,qy,qz,qw"
TIME, X, Y = 0, 1, 2


def read_track(path: Path) -> Array:
    """(n >= 2, 3) t_s from 0, north_m, east_m; InputError names the file, the line, the value and what would be right."""
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; a recorded track is wanted") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a recorded track: {error}") from None
    if not lines or lines[0].strip() != HEADER:
        found = lines[0].strip()[:80] if lines else ""
        raise InputError(f"{path}: line 1 = '{found}': must be the header {HEADER}")
    rows = np.array([_row(path, number, line) for number, line in enumerate(lines[1:], 2) if line.strip()]).reshape(-1, 3)
    if len(rows) < 2:
        raise InputError(f"{path}: {len(rows)} rows below the header; a track needs at least 2")
    back = np.flatnonzero(np.diff(rows[:, 0]) <= 0.0)
    if len(back):
        number, value = _line_number(lines, int(back[0]) + 1), rows[back[0] + 1, 0]
        raise InputError(f"{path}: line {number}: timestamp = {value}: must be later than the one before, {rows[back[0], 0]}")
    rows[:, 0] -= rows[0, 0]
    return rows


def _row(path: Path, number: int, line: str) -> tuple[float, float, float]:
    """Time, north, east of one line."""
    names, words = HEADER.split(","), line.split(",")
    if len(words) != len(names):
        raise InputError(f"{path}: line {number}: {len(words)} values; must be {len(names)}, {HEADER}")
    return tuple(_number(path, number, names[column], words[column]) for column in (TIME, Y, X))  # type: ignore[return-value]


def _number(path: Path, number: int, name: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}: line {number}: {name} = '{word.strip()[:40]}': must be a finite number")
    return value


def _line_number(lines: list[str], row: int) -> int:
    """The line in the file of a row below the header, blank lines counted."""
    return [number for number, line in enumerate(lines[1:], 2) if line.strip()][row]
