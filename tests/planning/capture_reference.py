"""The capture rule over points: what the planner's and the simulator's encirclement are tested against."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flightapp.planning.capture import CaptureRule, dwell_since_s, encloses, has_dwelt
from flightapp.planning.plane import Point


def encircled(evader: Point, pursuers: Sequence[Point], rule: CaptureRule) -> bool:
    """Whether `pursuers`, all of them, surround `evader` within the rule's zone."""
    if not pursuers or any(math.dist(pursuer, evader) > rule.zone_m for pursuer in pursuers):
        return False
    bearings = np.array([math.atan2(e - evader[1], n - evader[0]) for n, e in pursuers])
    return encloses(bearings, rule.angular_gap_min_deg)


class Dwell:
    """Latches once a condition has held without a break for `duration_s`."""

    def __init__(self, duration_s: float) -> None:
        self._duration_s = duration_s
        self._since_s = math.nan
        self.done = False

    def update(self, t_s: float, holds: bool) -> bool:
        self._since_s = dwell_since_s(self._since_s, t_s, holds)
        self.done = self.done or has_dwelt(self._since_s, t_s, self._duration_s)
        return self.done
