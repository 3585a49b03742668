"""When the evader counts as captured: the continuous capture check, the encirclement and its dwell."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from flightapp.core.angles import TWO_PI
from flightapp.planning.parameters import StrategyParameters
from flightapp.planning.plane import Point, nearest_on_segment


class CaptureRule(StrategyParameters):
    """The mission's capture section, as it reaches a strategy."""

    radius_m: float = Field(default=0.4, gt=0)
    """A pursuer within this distance satisfies the capture condition."""
    hold_radius_m: float = Field(default=0.4, gt=0)
    """Radius of the encirclement."""
    hold_tolerance_m: float = Field(default=1.0, gt=0)
    """How far outside the hold radius a pursuer still encircles."""
    angular_gap_min_deg: float = Field(default=90.0, ge=0, le=180)
    """Two pursuers must be seen from the evader at least this far apart; three or more must enclose it."""
    dwell_s: float = Field(default=0.5, ge=0)
    """How long the encirclement must last."""
    mode: Literal["first", "all"] = "all"
    """`first`: the first pursuer within the radius ends it; `all`: the whole team encircles."""

    @property
    def zone_m(self) -> float:
        """Distance from the evader within which a pursuer that has captured still holds it."""
        return max(self.radius_m, self.hold_radius_m + self.hold_tolerance_m)

    @property
    def slot_radius_m(self) -> float:
        """Radius to fly to: the hold radius, and well inside the capture radius."""
        return min(self.hold_radius_m, 0.8 * self.radius_m)


def closest_approach_between_m(own_before: Point, own: Point, evader_before: Point, evader: Point) -> float:
    """Smallest distance of two vehicles that moved along straight segments in the same time."""
    start = (own_before[0] - evader_before[0], own_before[1] - evader_before[1])
    end = (own[0] - evader[0], own[1] - evader[1])
    return math.hypot(*nearest_on_segment((0.0, 0.0), (start, end)))


def encircled(evader: Point, pursuers: Sequence[Point], rule: CaptureRule) -> bool:
    """Whether `pursuers`, all of them, surround `evader` within the rule's zone."""
    if not pursuers or any(math.dist(pursuer, evader) > rule.zone_m for pursuer in pursuers):
        return False
    gap = widest_gap_rad([math.atan2(e - evader[1], n - evader[0]) for n, e in pursuers])
    if len(pursuers) == 1:
        return True
    if len(pursuers) == 2:
        return TWO_PI - gap >= math.radians(rule.angular_gap_min_deg)
    return gap < math.pi


def widest_gap_rad(bearings_rad: Sequence[float]) -> float:
    """The widest angle between neighbouring bearings; 2 pi for one."""
    ordered = sorted(bearings_rad)
    gaps = [after - before for before, after in itertools.pairwise(ordered)]
    return max([*gaps, TWO_PI - (ordered[-1] - ordered[0])])


class Dwell:
    """Latches once a condition has held without a break for `duration_s`."""

    def __init__(self, duration_s: float) -> None:
        self._duration_s = duration_s
        self._since_s: float | None = None
        self.done = False

    def update(self, t_s: float, holds: bool) -> bool:
        if not holds:
            self._since_s = None
        elif self._since_s is None:
            self._since_s = t_s
        self.done = self.done or (self._since_s is not None and t_s - self._since_s >= self._duration_s - 1e-9)
        return self.done
