"""Own recent positions at a fixed rate, whatever the rate of decisions: for the memory penalty and the trap trigger."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled
from flightapp.planning.plane import Point


class History:
    """The last `samples` positions, one every `period_s`."""

    def __init__(self, samples: int, period_s: float) -> None:
        self._points = np.zeros((samples, 2))
        self._period_s = period_s
        self._count = 0
        self._next_s = -np.inf

    def add(self, t_s: float, point: Point) -> None:
        """Take `point` if a sample is due at `t_s`; a gap in time starts the history anew."""
        if t_s - self._next_s > 5.0 * self._period_s:
            self._count = 0
            self._next_s = t_s
        if t_s < self._next_s - 1e-9:
            return
        self._next_s += self._period_s
        if self._count == len(self._points):
            self._points[:-1] = self._points[1:]
            self._count -= 1
        self._points[self._count] = point
        self._count += 1

    def clear(self) -> None:
        self._count = 0

    @property
    def points(self) -> Array:
        """(k, 2) m, oldest first."""
        return self._points[: self._count]

    def variance_m2(self, samples: int) -> float | None:
        """Trace of the covariance of the last `samples` positions; None until there are so many."""
        if self._count < samples:
            return None
        return _variance_m2(self._points[self._count - samples : self._count])


@compiled("f8(f8[:,::1])")
def _variance_m2(points: Array) -> float:
    north = 0.0
    east = 0.0
    for i in range(points.shape[0]):
        north += points[i, 0]
        east += points[i, 1]
    north /= points.shape[0]
    east /= points.shape[0]
    total: float = 0.0
    for i in range(points.shape[0]):
        total += (points[i, 0] - north) ** 2 + (points[i, 1] - east) ** 2
    variance: float = total / points.shape[0]
    return variance
