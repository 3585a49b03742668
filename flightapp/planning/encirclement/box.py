"""The box around the evader: as wide as the pursuers' extent until they encircle it, then smaller and smaller.

Wang et al., arXiv 2312.01326, eqs. 6-8 and 15. From the moment of the encirclement on the box follows from that moment and the
half sizes then, so that vehicles that know both compute the same one. The shrinking waits while the evader is not seen.
"""

from __future__ import annotations

import math

from flightapp.core.types import Array
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.planning.plane import Point

NEAREST_REST_SHARE = 0.79
"""The nearest pursuer rests at no more than this share of the half size: the box must be no larger than what that reaches."""
BUFFER_SHARE = 1.5
"""Times the buffer times the root of the number of vehicles: half a box that is not all buffers."""
CAPTURE_SHARE = 0.75


class Box:
    """Half sizes from period to period."""

    def __init__(self, parameters: EncirclementParameters, speed_max_m_s: float, buffer_m: float) -> None:
        self._parameters, self._speed_max_m_s, self._buffer_m = parameters, speed_max_m_s, buffer_m
        self.reset()

    def reset(self) -> None:
        """Not encircled yet."""
        self.since_s: float | None = None
        """The moment of the encirclement."""
        self._at_first: Point = (0.0, 0.0)
        self._shrunk_m = 0.0
        self._outside_s = 0.0

    def half_min_m(self, pursuers: int, evader_age_s: float) -> tuple[float, bool]:
        """Smallest half size for so many, and whether they are too many for the capture radius."""
        wanted, crowded = self._parameters.box_half_min_m, False
        if wanted is None:
            rule = self._parameters.capture
            if rule.mode == "first":
                reached_m = rule.radius_m
                wanted = CAPTURE_SHARE * reached_m
            else:
                reached_m = rule.zone_m
                wanted = min(rule.hold_radius_m / NEAREST_REST_SHARE, reached_m)
            room_m = BUFFER_SHARE * self._buffer_m * math.sqrt(pursuers + 1)
            most_m = reached_m / NEAREST_REST_SHARE
            crowded = room_m > most_m
            wanted = max(wanted, min(room_m, most_m))
        return wanted + self._parameters.evader_speed_assumed_m_s * evader_age_s, crowded

    def half_sizes_m(
        self, t_s: float, period_s: float, team: Array, evader: Point, evader_age_s: float, hull_m: float, latched_by_mate: bool
    ) -> Point:
        """Of this period; hull_m: the evader's distance to the pursuers' hull, negative inside; 0 is not encircled."""
        parameters = self._parameters
        least, _ = self.half_min_m(len(team), evader_age_s)
        extent = self._extent_m(team, evader, least)
        if self.since_s is None:
            if hull_m >= 0.0 and not (latched_by_mate and parameters.shrink == "latch"):
                return extent
            self.since_s, self._at_first, self._shrunk_m, self._outside_s = t_s, extent, 0.0, 0.0
        elif evader_age_s <= parameters.target_stale_s:
            self._shrunk_m += parameters.shrink_share * self._speed_max_m_s * period_s
        if parameters.shrink == "eq8":
            return extent
        if parameters.shrink == "reopen":
            self._outside_s = self._outside_s + period_s if hull_m >= 0.0 else 0.0
            if self._outside_s > parameters.reopen_after_s:
                self.since_s = None
                return extent
        n, e = self._at_first
        return max(n - self._shrunk_m, least), max(e - self._shrunk_m, least)

    def _extent_m(self, team: Array, evader: Point, least: float) -> Point:
        n = max(float(abs(team[:, 0] - evader[0]).max()), least)
        e = max(float(abs(team[:, 1] - evader[1]).max()), least)
        return (n, e) if self._parameters.box == "rect" else (max(n, e),) * 2
