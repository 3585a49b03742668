"""A recorded track laid into the mission: where it is and how fast after a time."""

from __future__ import annotations

import bisect
import math

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.plane import Point


class Track:
    """Rows t_s from 0, north_m, east_m, from the origin of its own frame."""

    def __init__(self, rows: Array) -> None:
        self.duration_s = float(rows[-1, 0] - rows[0, 0])
        self._times_s: list[float] = (rows[:, 0] - rows[0, 0]).tolist()
        places = rows[:, 1:] - rows[0, 1:]
        self._places: list[list[float]] = places.tolist()
        velocities: Array = np.asarray(np.gradient(places, self._times_s, axis=0))
        self._velocities: list[list[float]] = velocities.tolist()

    def at(self, time_s: float) -> tuple[Point, Point]:
        """Place (m) from the first row's, and velocity (m/s), `time_s` after the first row; standing at the last."""
        times = self._times_s
        if time_s >= self.duration_s:
            north, east = self._places[-1]
            return (north, east), (0.0, 0.0)
        row = bisect.bisect_right(times, time_s) - 1
        part = (time_s - times[row]) / (times[row + 1] - times[row])
        return _between(self._places, row, part), _between(self._velocities, row, part)

    def bearing_rad(self) -> float:
        """Where its point farthest from the first lies."""
        north, east = max(self._places, key=lambda place: math.hypot(*place))
        return math.atan2(east, north)


def _between(values: list[list[float]], row: int, part: float) -> Point:
    (an, ae), (bn, be) = values[row], values[row + 1]
    return an + part * (bn - an), ae + part * (be - ae)
