"""Whether the capture rule is met, as one pursuer sees it."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.capture import CaptureRule, dwell_since_s, encloses, has_dwelt
from flightapp.planning.plane import Point


class CaptureWatch:
    """`first`: somebody is within the radius. Else: all are within the zone and surround the evader, for the dwell time."""

    def __init__(self, rule: CaptureRule) -> None:
        self._rule = rule
        self._since_s = math.nan

    def captured(self, t_s: float, team: Array, distances_m: Array, evader: Point, is_seen: bool) -> bool:
        """team (k, 2) with the own place first, and how far each is from the evader. Where it is only guessed nobody captures."""
        rule = self._rule
        if rule.mode == "first":
            return is_seen and bool(distances_m.min() <= rule.radius_m)
        bearings = np.arctan2(team[:, 1] - evader[1], team[:, 0] - evader[0])
        holds = is_seen and bool(distances_m.max() <= rule.zone_m) and encloses(bearings, rule.angular_gap_min_deg)
        self._since_s = dwell_since_s(self._since_s, t_s, holds)
        return bool(has_dwelt(self._since_s, t_s, rule.dwell_s))
