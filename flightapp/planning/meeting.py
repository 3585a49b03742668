"""When vehicles can be where a target will be, and the first place where all of them can (CPPPEA, 2.12 of Li et al. 2025).

Angles are clockwise from north; the source's run the other way round, which its formulas do not notice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.angles import TWO_PI
from flightapp.core.types import Array
from flightapp.planning.prediction import Path

TURN_SHARE = 0.25
"""Of the shorter of driving and turning, which overlap: added to the longer."""
MARGIN_S = 0.5
MEETING_MIN = 3
"""So many must be able to meet: fewer cannot enclose."""


def driving_s(distance_m: Array, speed_m_s: Array, speed_max_m_s: Array, acceleration_m_s2: float) -> Array:
    """Shortest time for `distance_m` from `speed_m_s` >= 0; all broadcast."""
    speed, top, a = np.minimum(speed_m_s, speed_max_m_s), speed_max_m_s, acceleration_m_s2
    reaches_top = distance_m > (top**2 - speed**2) / (2.0 * a)
    long_s = (2.0 * a * distance_m + (top - speed) ** 2) / (2.0 * a * top)
    short_s = (np.sqrt(speed**2 + 2.0 * a * distance_m) - speed) / a
    return np.asarray(np.where(reaches_top, long_s, short_s))


def turning_s(angle_rad: Array, rate_rad_s: Array, rate_max_rad_s: float, acceleration_rad_s2: float) -> Array:
    """Shortest time to turn by `angle_rad` from `rate_rad_s` to rest; all broadcast. Overshoot is counted."""
    alpha = acceleration_rad_s2
    rest = angle_rad - rate_rad_s * np.abs(rate_rad_s) / (2.0 * alpha)
    sign = np.where(rest < 0.0, -1.0, 1.0)
    rate, way = sign * rate_rad_s, sign * angle_rad
    peak = np.minimum(rate_max_rad_s, np.sqrt(np.maximum(alpha * way + 0.5 * rate**2, 0.0)))
    peak = np.maximum(peak, np.maximum(rate, 0.0))
    even = np.maximum(0.0, way - (2.0 * peak**2 - rate**2) / (2.0 * alpha)) / rate_max_rad_s
    times = (peak - rate) / alpha + peak / alpha + even
    return np.asarray(np.where(rest == 0.0, np.abs(rate_rad_s) / alpha, times))


def rest_turn_s(angle_rad: float, rate_max_rad_s: float, acceleration_rad_s2: float) -> float:
    """From rest to rest."""
    return float(turning_s(np.array(abs(angle_rad)), np.array(0.0), rate_max_rad_s, acceleration_rad_s2))


@dataclass(frozen=True, slots=True)
class Runners:
    """Vehicles that are to meet a target, all with the same acceleration and turning."""

    places_m: Array  # (n, 2)
    headings_rad: Array  # (n,)
    speeds_m_s: Array  # (n,)
    speeds_max_m_s: Array  # (n,)
    acceleration_m_s2: float
    turn_rate_max_rad_s: float
    turn_acceleration_rad_s2: float

    def times_s(self, places_m: Array, detours_m: Array | float = 0.0) -> Array:
        """(n, k) s to `places_m` (k, 2), by ways that are longer than straight by `detours_m`."""
        way = places_m[None, :, :] - self.places_m[:, None, :]
        distance = np.hypot(way[..., 0], way[..., 1]) + detours_m
        angle = np.arctan2(way[..., 1], way[..., 0]) - self.headings_rad[:, None]
        angle = (angle + np.pi) % TWO_PI - np.pi
        angle = np.where(distance < 1e-6, 0.0, angle)
        driving = driving_s(distance, self.speeds_m_s[:, None], self.speeds_max_m_s[:, None], self.acceleration_m_s2)
        turning = turning_s(angle, np.zeros_like(angle), self.turn_rate_max_rad_s, self.turn_acceleration_rad_s2)
        return np.maximum(driving, turning) + TURN_SHARE * np.minimum(driving, turning)


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where on the path, and who cannot be there in time."""

    index: int
    late: NDArray[np.bool_]  # (n,)
    reachable: bool
    """All that are not late are in time; False: nobody else could be left out, and this is the least bad."""


def meeting_of(runners: Runners, path: Path, detours_m: Array | float = 0.0) -> Meeting:
    """The first place of `path` where all can be in time, without those who cannot as long as `MEETING_MIN` are left.

    Never by bisection: a faster target can be met early and late but not between.
    """
    due_s = path.step_s * np.arange(len(path.places_m))
    margin_s = MARGIN_S + 2.0 * path.deviations_m[None, :] / runners.speeds_max_m_s[:, None]
    lateness = runners.times_s(path.places_m, detours_m) + margin_s - due_s[None, :]
    late = np.zeros(len(lateness), dtype=bool)
    while True:
        together = (lateness[~late] <= 0.0).all(axis=0)
        if together.any():
            return Meeting(int(np.argmax(together)), late, True)
        if int((~late).sum()) <= MEETING_MIN:
            total = np.maximum(lateness[~late], 0.0).sum(axis=0)
            return Meeting(int(np.argmin(total)), late, False)
        least = np.where(late, -np.inf, lateness.min(axis=1))
        late[int(np.argmax(least))] = True
