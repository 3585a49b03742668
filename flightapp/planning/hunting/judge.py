"""Whether the capture's condition holds, as one hunter sees it."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.clearance import way_gap_m
from flightapp.planning.capture import CaptureRule, dwell_since_s, encloses, forms_polygon, has_dwelt
from flightapp.planning.hunting.sight import View
from flightapp.planning.plane import Point


class Judge:
    """Remembers since when the target is surrounded, and that it was captured."""

    def __init__(self, rule: CaptureRule, stale_s: float) -> None:
        self._rule, self._stale_s = rule, stale_s
        self._since_s = math.nan
        self._before: Point | None = None
        self.surrounded = False
        self.captured = False

    def step(self, view: View) -> None:
        """Judge this moment; see `surrounded` and `captured`."""
        self.surrounded = self._is_surrounded(view)
        self._since_s = dwell_since_s(self._since_s, view.t_s, self.surrounded)
        self.captured = self.captured or bool(has_dwelt(self._since_s, view.t_s, self._rule.dwell_s))

    def _is_surrounded(self, view: View) -> bool:
        known = not math.isnan(view.target_age_s) and view.target_age_s <= self._stale_s
        before, self._before = self._before, None
        if not known:
            return False
        offset = view.own_m[0] - view.target_m[0], view.own_m[1] - view.target_m[1]
        self._before = offset
        if self._rule.mode == "first":
            start = offset if before is None else before
            return bool(way_gap_m(*start, offset[0] - start[0], offset[1] - start[1], self._rule.radius_m) <= 0.0)
        if not view.team_complete or view.distance_m > self._rule.zone_m:
            return False
        ways = np.concatenate((np.array([offset]), view.team[:, :2] - np.array(view.target_m)))
        if (np.hypot(ways[:, 0], ways[:, 1]) > self._rule.zone_m).any():
            return False
        bearings = np.ascontiguousarray(np.arctan2(ways[:, 1], ways[:, 0]))
        if self._rule.mode == "formation":
            distances, gap = np.hypot(ways[:, 0], ways[:, 1]), math.radians(self._rule.gap_tolerance_deg)
            return bool(forms_polygon(bearings, distances, self._rule.hold_radius_m, self._rule.hold_tolerance_m, gap))
        return bool(encloses(bearings, self._rule.angular_gap_min_deg))
