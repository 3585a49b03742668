"""Estimate of the evader from time-stamped measurements of any source, in any order of arrival."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flightapp.core.types import Array, TargetTrack

GATES = {3: 16.27, 6: 22.46}
"""99.9 % of the squared Mahalanobis distance, by degrees of freedom."""
MAGNITUDE_MAX = 1e7
TIME_MAX_S = 1e11
SIGMA_MIN, SIGMA_MAX = 1e-3, 1e4


@dataclass(frozen=True, slots=True)
class TargetFilterParameters:
    """How the evader moves and how measurements are kept."""

    acceleration_density_m2_s3: float = 2.0
    """Power density of the white acceleration that stands for the evader's manoeuvres, per axis."""
    unknown_speed_sigma_m_s: float = 5.0
    """Standard deviation of the velocity after a first measurement that has none."""
    rejections_max: int = 4
    """So many measurements in a row outside the gate, and the filter starts anew from the last of them."""
    gap_max_s: float = 10.0
    """After a longer gap the filter starts anew: the old motion says nothing any more."""
    ring_length: int = 48
    """Past measurements kept for late arrivals; older ones than all of them are refused."""


class _Measurement(NamedTuple):
    t_s: float
    position: tuple[float, float, float]
    velocity: tuple[float, float, float] | None
    position_sigma_m: float
    velocity_sigma_m_s: float

    def key(self) -> tuple[float, tuple[float, ...], tuple[float, ...], float, float]:
        """Total order that does not depend on the order of arrival."""
        return self.t_s, self.position, self.velocity or (), self.position_sigma_m, self.velocity_sigma_m_s


class _Estimate(NamedTuple):
    t_s: float
    mean: Array  # (6,)
    covariance: Array  # (6, 6)
    measured_s: float
    rejections: int


class TargetFilter:
    """Constant-velocity Kalman filter over position and velocity, mission frame NED. Deterministic; reads no clock.

    A measurement that arrives late is put at its place in time and everything after it is filtered again, so the order of
    arrival does not matter within the ring of past measurements.
    """

    def __init__(self, parameters: TargetFilterParameters | None = None) -> None:
        self._parameters = TargetFilterParameters() if parameters is None else parameters
        self._measurements: list[_Measurement] = []
        self._estimates: list[_Estimate] = []
        self._base: _Estimate | None = None

    def update(
        self,
        t_s: float,
        position_ned_m: Array,
        velocity_ned_m_s: Array | None,
        position_sigma_m: float,
        velocity_sigma_m_s: float,
    ) -> bool:
        """Take in a measurement that was true at `t_s`: position (3,), velocity (3,) or None, standard deviations per axis.

        False, and nothing changes, when a number is not finite or absurd (the velocity's only where there is one), a
        deviation is not positive, or the measurement is older than everything kept.
        """
        measurement = _measurement(t_s, position_ned_m, velocity_ned_m_s, position_sigma_m, velocity_sigma_m_s)
        if measurement is None or (self._base is not None and measurement.t_s < self._base.t_s):
            return False
        place = bisect.bisect_right(self._measurements, measurement.key(), key=_Measurement.key)
        self._measurements.insert(place, measurement)
        del self._estimates[place:]
        estimate = self._estimates[-1] if self._estimates else self._base
        for later in self._measurements[place:]:
            estimate = self._filtered(estimate, later)
            self._estimates.append(estimate)
        if len(self._measurements) > self._parameters.ring_length:
            self._base = self._estimates.pop(0)
            del self._measurements[0]
        return True

    def predict(self, t_s: float) -> TargetTrack | None:
        """The track at `t_s` from the measurements up to then; None before the first. `age_s` counts from the newest one used."""
        if not math.isfinite(t_s):
            return None
        place = bisect.bisect_right(self._estimates, t_s, key=lambda estimate: estimate.t_s)
        estimate = self._estimates[place - 1] if place > 0 else self._base
        if estimate is None or estimate.t_s > t_s:
            return None
        mean, covariance = self._moved(estimate, t_s)
        return TargetTrack(t_s, mean[:3].copy(), mean[3:].copy(), covariance, t_s - estimate.measured_s)

    def reset(self) -> None:
        """Forget everything."""
        self._measurements.clear()
        self._estimates.clear()
        self._base = None

    def _filtered(self, before: _Estimate | None, measurement: _Measurement) -> _Estimate:
        if before is None or measurement.t_s - before.measured_s > self._parameters.gap_max_s:
            return self._started(measurement)
        mean, covariance = self._moved(before, measurement.t_s)
        size = 3 if measurement.velocity is None else 6
        values = np.array(measurement.position + (measurement.velocity or ()))
        variances = np.array([measurement.position_sigma_m**2] * 3 + [measurement.velocity_sigma_m_s**2] * (size - 3))
        innovation = values - mean[:size]
        spread = covariance[:size, :size] + np.diag(variances)
        weighted = np.linalg.solve(spread, np.column_stack((innovation, covariance[:size, :])))
        if not float(innovation @ weighted[:, 0]) <= GATES[size]:
            if before.rejections + 1 >= self._parameters.rejections_max:
                return self._started(measurement)
            return _Estimate(measurement.t_s, mean, covariance, before.measured_s, before.rejections + 1)
        gain = weighted[:, 1:].T
        rest = np.eye(6)
        rest[:, :size] -= gain
        updated = rest @ covariance @ rest.T + (gain * variances) @ gain.T
        return _Estimate(measurement.t_s, mean + gain @ innovation, 0.5 * (updated + updated.T), measurement.t_s, 0)

    def _started(self, measurement: _Measurement) -> _Estimate:
        known = measurement.velocity is not None
        speed_sigma = measurement.velocity_sigma_m_s if known else self._parameters.unknown_speed_sigma_m_s
        variances = [measurement.position_sigma_m**2] * 3 + [speed_sigma**2] * 3
        mean = np.array(measurement.position + (measurement.velocity or (0.0, 0.0, 0.0)))
        return _Estimate(measurement.t_s, mean, np.diag(variances), measurement.t_s, 0)

    def _moved(self, estimate: _Estimate, t_s: float) -> tuple[Array, Array]:
        """Mean and covariance of `estimate` carried on to `t_s`."""
        dt = t_s - estimate.t_s
        mean = estimate.mean.copy()
        mean[:3] += dt * mean[3:]
        motion = np.eye(6)
        motion[:3, 3:] = dt * np.eye(3)
        density = self._parameters.acceleration_density_m2_s3
        noise = density * np.kron(np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]]), np.eye(3))
        covariance = motion @ estimate.covariance @ motion.T + noise
        return mean, 0.5 * (covariance + covariance.T)


def _measurement(
    t_s: float, position: Array, velocity: Array | None, position_sigma_m: float, velocity_sigma_m_s: float
) -> _Measurement | None:
    """The measurement with usable numbers, else None."""
    numbers = [*np.asarray(position, dtype=np.float64).tolist(), *([] if velocity is None else np.asarray(velocity).tolist())]
    if not all(abs(number) < MAGNITUDE_MAX for number in numbers) or not abs(t_s) < TIME_MAX_S:
        return None
    sigmas = [position_sigma_m] + ([] if velocity is None else [velocity_sigma_m_s])
    if not all(0.0 < sigma < math.inf for sigma in sigmas):
        return None
    bounded = [min(max(sigma, SIGMA_MIN), SIGMA_MAX) for sigma in sigmas]
    north, east, down = numbers[:3]
    speed = None if velocity is None else (numbers[3], numbers[4], numbers[5])
    return _Measurement(t_s, (north, east, down), speed, bounded[0], bounded[-1] if velocity is not None else 0.0)
