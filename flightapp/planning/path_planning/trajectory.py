"""A path with times: where the vehicle is to be, how fast, and with which acceleration, at any time (section 2.3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array

SHARE = 0.5
"""Of the acceleration limit, along the way and across it each: tracking needs the rest."""
SAME_PLACE_M = 1e-6
REPAIRS = 10
"""Times that the speed is lowered where the cubic between two knots needs more than the acceleration limit."""


@dataclass(frozen=True, slots=True)
class FlightLimits:
    """What the vehicle that is to fly the way can do."""

    speed_max_m_s: float
    climb_rate_max_m_s: float
    acceleration_max_m_s2: float


@dataclass(frozen=True, slots=True)
class Moment:
    """Position, velocity and acceleration (3,) that are asked for at one time, NED."""

    position_ned_m: Array
    velocity_ned_m_s: Array
    acceleration_ned_m_s2: Array


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Knots: times (n,) from 0, positions and velocities (n, 3); cubic between them, so position and velocity are continuous."""

    times_s: Array
    positions_ned_m: Array
    velocities_ned_m_s: Array

    @property
    def duration_s(self) -> float:
        return float(self.times_s[-1])

    @property
    def length_m(self) -> float:
        return float(np.linalg.norm(np.diff(self.positions_ned_m, axis=0), axis=1).sum())

    def at(self, t_s: float) -> Moment:
        """What is asked for at `t_s`; at rest where it begins or ends, before and after it."""
        last = len(self.times_s) - 1
        if last == 0 or t_s >= self.duration_s:
            return Moment(self.positions_ned_m[last], np.zeros(3), np.zeros(3))
        if t_s < 0.0:
            return Moment(self.positions_ned_m[0], np.zeros(3), np.zeros(3))
        k = int(np.searchsorted(self.times_s, t_s, side="right")) - 1
        lasts = float(self.times_s[k + 1] - self.times_s[k])
        u = (t_s - float(self.times_s[k])) / lasts
        p, q = self.positions_ned_m[k], self.positions_ned_m[k + 1]
        v, w = lasts * self.velocities_ned_m_s[k], lasts * self.velocities_ned_m_s[k + 1]
        across = q - p
        square = 3.0 * across - 2.0 * v - w
        cube = v + w - 2.0 * across
        return Moment(
            p + u * (v + u * (square + u * cube)),
            (v + u * (2.0 * square + u * 3.0 * cube)) / lasts,
            (2.0 * square + 6.0 * u * cube) / (lasts * lasts),
        )

    def slowed(self, factor: float) -> Trajectory:
        """The same way at `factor` times the speed."""
        return Trajectory(self.times_s / factor, self.positions_ned_m, factor * self.velocities_ned_m_s)


def timed(places: Array, limits: FlightLimits, speed_m_s: float = 0.0) -> Trajectory:
    """The time law of the places (n, 3) of a smooth way, which must lie close to each other, from `speed_m_s` to rest.

    As fast as speed, climb rate and the curve allow: v <= sqrt(a/kappa) with half of the acceleration limit; then forwards and
    backwards with the same limit along the way.
    """
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    keep = np.concatenate(([True], steps > SAME_PLACE_M))
    places = places[keep]
    if len(places) == 1:
        return Trajectory(np.zeros(1), places, np.zeros((1, 3)))
    if len(places) == 2:
        places = np.insert(places, 1, places.mean(axis=0), axis=0)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    units = np.diff(places, axis=0) / steps[:, None]
    tangents, curvature = _directions(units, steps)
    acceleration = SHARE * limits.acceleration_max_m_s2
    steep = np.maximum(np.abs(tangents[:, 2]), 1e-9)
    fastest = np.minimum(limits.speed_max_m_s, limits.climb_rate_max_m_s / steep)
    fastest = np.minimum(fastest, np.sqrt(acceleration / np.maximum(curvature, 1e-9)))
    fastest[0], fastest[-1] = min(speed_m_s, float(fastest[0])), 0.0
    for _ in range(REPAIRS):
        trajectory = _with_speeds(places, tangents, steps, _reachable(fastest, steps, acceleration))
        excess = _accelerations(trajectory) / limits.acceleration_max_m_s2
        if excess.max() <= 1.0:
            return trajectory
        slower = np.where(excess > 1.0, 0.95 / np.sqrt(np.maximum(excess, 1.0)), 1.0)
        fastest[:-1] *= slower
        fastest[1:] *= slower
    return trajectory.slowed(1.0 / math.sqrt(float(excess.max())))


def _reachable(fastest: Array, steps: Array, acceleration: float) -> Array:
    """The greatest speeds (n,) below `fastest` between which `steps` (n - 1,) are long enough for `acceleration`."""
    speeds, lengths = fastest.tolist(), steps.tolist()
    for k in range(1, len(speeds)):
        speeds[k] = min(speeds[k], math.sqrt(speeds[k - 1] ** 2 + 2.0 * acceleration * lengths[k - 1]))
    for k in range(len(speeds) - 2, -1, -1):
        speeds[k] = min(speeds[k], math.sqrt(speeds[k + 1] ** 2 + 2.0 * acceleration * lengths[k]))
    return np.array(speeds)


def _with_speeds(places: Array, tangents: Array, steps: Array, speeds: Array) -> Trajectory:
    lasts = 2.0 * steps / (speeds[:-1] + speeds[1:])
    return Trajectory(np.concatenate(([0.0], np.cumsum(lasts))), places, speeds[:, None] * tangents)


def _accelerations(trajectory: Trajectory) -> Array:
    """Greatest acceleration (n - 1,) between each two knots: it is linear there, so that of the ends decide."""
    lasts = np.diff(trajectory.times_s)[:, None]
    across = np.diff(trajectory.positions_ned_m, axis=0) / lasts
    v, w = trajectory.velocities_ned_m_s[:-1], trajectory.velocities_ned_m_s[1:]
    begin, end = (6.0 * across - 4.0 * v - 2.0 * w) / lasts, (2.0 * v + 4.0 * w - 6.0 * across) / lasts
    return np.asarray(np.maximum(np.linalg.norm(begin, axis=1), np.linalg.norm(end, axis=1)))


def _directions(units: Array, steps: Array) -> tuple[Array, Array]:
    """Unit tangents (n, 3) and curvatures (n,) in 1/m at the places between which `units` (n - 1, 3) lead over `steps` m."""
    middle = units[:-1] + units[1:]
    norm = np.linalg.norm(middle, axis=1)
    middle = np.where(norm[:, None] > SAME_PLACE_M, middle / np.maximum(norm, SAME_PLACE_M)[:, None], units[1:])
    tangents = np.vstack((units[:1], middle, units[-1:]))
    turns = np.arccos(np.clip((units[:-1] * units[1:]).sum(axis=1), -1.0, 1.0))
    curvature = np.concatenate(([0.0], turns / (0.5 * (steps[:-1] + steps[1:])), [0.0]))
    return tangents, curvature
