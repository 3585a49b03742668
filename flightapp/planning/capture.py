"""When the evader counts as captured: the continuous capture check, the encirclement and its dwell."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.parameters import StrategyParameters


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
    mode: Literal["first", "all", "formation"] = "all"
    """`first`: the first pursuer within the radius ends it; `all`: the team encircles; `formation`: in a regular polygon."""
    gap_tolerance_deg: float = Field(default=15.0, ge=0, le=180)
    """Formation: by how much the widest gap between neighbours, seen from the evader, may exceed that of a regular polygon."""

    @property
    def zone_m(self) -> float:
        """Distance from the evader within which a pursuer that has captured still holds it."""
        return max(self.radius_m, self.hold_radius_m + self.hold_tolerance_m)

    @property
    def slot_radius_m(self) -> float:
        """Radius to fly to: the hold radius, and well inside the capture radius."""
        return min(self.hold_radius_m, 0.8 * self.radius_m)


@compiled("void(f8[::1])")
def _sort(values: Array) -> None:
    """Ascending, by insertion: there are a few, and the library's sort takes seconds to compile."""
    for i in range(1, values.shape[0]):
        value = values[i]
        k = i
        while k > 0 and values[k - 1] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value


@compiled("f8(f8[::1])")
def widest_gap_rad(bearings_rad: Array) -> float:
    """The widest angle between neighbours among `bearings_rad` (k > 0,), which are sorted on return; 2 pi for one."""
    _sort(bearings_rad)
    last = bearings_rad.shape[0] - 1
    widest: float = 2.0 * math.pi - (bearings_rad[last] - bearings_rad[0])
    for i in range(last):
        widest = max(widest, bearings_rad[i + 1] - bearings_rad[i])
    return widest


@compiled("b1(f8[::1],f8)")
def encloses(bearings_rad: Array, angular_gap_min_deg: float) -> bool:
    """Whether pursuers seen from the evader at `bearings_rad` (k > 0,), which are sorted on return, surround it."""
    count = bearings_rad.shape[0]
    gap = widest_gap_rad(bearings_rad)
    if count == 1:
        return True
    if count == 2:
        return bool(2.0 * math.pi - gap >= math.radians(angular_gap_min_deg))
    return bool(gap < math.pi)


@compiled("b1(f8[::1],f8[::1],f8,f8,f8)")
def forms_polygon(bearings_rad: Array, distances_m: Array, radius_m: float, tolerance_m: float, gap_tolerance_rad: float) -> bool:
    """Whether pursuers seen from the evader at `bearings_rad` and `distances_m` (k,) stand as a regular polygon around it.

    At least three, each within `tolerance_m` of its corner on the circle of `radius_m`, however that is turned, with the evader
    inside and no gap wider than a regular one and `gap_tolerance_rad`. Both arrays are sorted by bearing on return.
    """
    count = bearings_rad.shape[0]
    if count < 3:
        return False
    for i in range(1, count):
        bearing, distance = bearings_rad[i], distances_m[i]
        k = i
        while k > 0 and bearings_rad[k - 1] > bearing:
            bearings_rad[k], distances_m[k] = bearings_rad[k - 1], distances_m[k - 1]
            k -= 1
        bearings_rad[k], distances_m[k] = bearing, distance
    regular = 2.0 * math.pi / count
    gap = widest_gap_rad(bearings_rad)
    if gap > regular + gap_tolerance_rad or gap >= math.pi:
        return False
    turned = 0.0
    for i in range(count):
        turned += (bearings_rad[i] - i * regular) / count
    for i in range(count):
        aside = math.cos(bearings_rad[i] - i * regular - turned)
        off2 = distances_m[i] * distances_m[i] + radius_m * radius_m - 2.0 * distances_m[i] * radius_m * aside
        if off2 > tolerance_m * tolerance_m:
            return False
    return True


@compiled("f8(f8,f8,b1)")
def dwell_since_s(since_s: float, t_s: float, holds: bool) -> float:
    """Since when a condition holds without a break; NaN where it does not."""
    if not holds:
        return math.nan
    return t_s if math.isnan(since_s) else since_s


@compiled("b1(f8,f8,f8)")
def has_dwelt(since_s: float, t_s: float, duration_s: float) -> bool:
    """Whether what holds since `since_s` (NaN: it does not) has held for `duration_s`."""
    return bool(t_s - since_s >= duration_s - 1e-9)
