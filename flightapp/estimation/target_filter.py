"""Estimate of the evader from time-stamped measurements of any source, in any order of arrival."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, TargetTrack
from flightapp.estimation.measurement import Measurement, told
from flightapp.estimation.multiple_models import STATES, advance, merge
from flightapp.estimation.refiltering import GATES_SEEN, GATES_TOLD, LEFT_OUT, Ring, make_ring, refilter


@dataclass(frozen=True, slots=True)
class MotionModel:
    """One way in which an evader flies."""

    is_turn: bool
    """With a turn rate of its own, unknown and estimated; else straight on."""
    acceleration_density_m2_s3: float
    """Power density of the white acceleration on each axis."""
    probability: float
    """Of this motion while nothing is known; those of all models add up to 1."""


STEADY = MotionModel(is_turn=False, acceleration_density_m2_s3=0.3, probability=0.35)
TURNING = MotionModel(is_turn=True, acceleration_density_m2_s3=2.0, probability=0.4)
MANOEUVRING = MotionModel(is_turn=False, acceleration_density_m2_s3=30.0, probability=0.25)


@dataclass(frozen=True, slots=True)
class TargetFilterParameters:
    """How the evader moves and how measurements are kept. Defaults: `flightapp bench tracking` on the recorded racing tracks."""

    models: tuple[MotionModel, ...] = (STEADY, TURNING, MANOEUVRING)
    change_rate_1_s: float = 1.5
    """How often an evader changes its motion."""
    turn_rate_sigma_rad_s: float = 1.5
    turn_time_s: float = 4.0
    """In this time a turn is forgotten, as far as nothing confirms it."""
    unknown_speed_sigma_m_s: float = 5.0
    """Standard deviation of the velocity after a first measurement that has none."""
    rejections_max: int = 4
    """So many of the evader's own messages in a row outside the gate, and the filter starts anew from the last of them."""
    gap_max_s: float = 10.0
    """After a longer gap the filter starts anew: the old motion says nothing any more."""
    seen_spread_max_m: float = 1.5
    """Where the prediction's deviation is larger, what a camera sees there is not taken for the evader."""
    ring_length: int = 64
    """Past measurements kept for late arrivals; older ones than all of them are refused."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How a measurement fitted the track when it came; nan where it started the track, or there was none."""

    is_used: bool
    distance_m: float
    """Between measured and predicted position, as far as it was measured."""
    nis: float
    """Normalised innovation squared: the squared Mahalanobis distance to the prediction."""


class TargetFilter:
    """Interacting multiple models over position, velocity and turn rate, mission frame NED. Deterministic; reads no clock.

    A measurement that arrives late is put at its place in time and everything after it is filtered again, so the order of
    arrival does not matter within the ring of past measurements: vehicles that hear the same believe the same.
    """

    def __init__(self, parameters: TargetFilterParameters | None = None) -> None:
        self._parameters = TargetFilterParameters() if parameters is None else parameters
        models = self._parameters.models
        self._models = np.array([(float(one.is_turn), one.acceleration_density_m2_s3, one.probability) for one in models])
        self._turning = np.array(
            (self._parameters.change_rate_1_s, self._parameters.turn_rate_sigma_rad_s, self._parameters.turn_time_s)
        )
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._ring: Ring = make_ring(self._parameters.ring_length + 2, len(self._models))
        self._measurements: list[Measurement] = []

    def update(
        self,
        t_s: float,
        position_ned_m: Array,
        velocity_ned_m_s: Array | None,
        position_sigma_m: float,
        velocity_sigma_m_s: float,
    ) -> bool:
        """Take in what the evader told of itself, true at `t_s`; see `measurement.told`. False where it is refused."""
        measurement = told(t_s, position_ned_m, velocity_ned_m_s, position_sigma_m, velocity_sigma_m_s)
        return measurement is not None and self.take(measurement) is not None

    def take(self, measurement: Measurement) -> Fit | None:
        """Take in a measurement; None, and nothing changes, when it is older than everything kept."""
        ring, measurements = self._ring, self._measurements
        if measurement.t_s < ring.t_s[0]:
            return None
        place = bisect.bisect_right(measurements, measurement)
        measurements.insert(place, measurement)
        slot = place + 1
        ring.open(slot, len(measurements))
        ring.t_s[slot] = measurement.t_s
        ring.named[slot] = measurement.is_named
        ring.lengths[slot] = len(measurement.rows)
        ring.rows[slot, : len(measurement.rows)] = measurement.rows
        self._refilter(slot)
        outcome, nis, distance_m = ring.fits[slot].tolist()
        if len(measurements) > self._parameters.ring_length:
            ring.drop_oldest(len(measurements) + 1)
            del measurements[0]
        return Fit(outcome != LEFT_OUT, distance_m, nis)

    def predict(self, t_s: float) -> TargetTrack | None:
        """The track at `t_s` from the measurements up to then; None before the first. `age_s` counts from the newest one used."""
        ring = self._ring
        if not math.isfinite(t_s):
            return None
        slot = bisect.bisect_right(self._measurements, t_s, key=lambda measurement: measurement.t_s)
        if ring.t_s[slot] > t_s or math.isnan(ring.measured_s[slot]):
            return None
        means, covariances, weights = ring.means[slot].copy(), ring.covariances[slot].copy(), ring.weights[slot].copy()
        advance(means, covariances, weights, t_s - ring.t_s[slot], self._models, self._turning)
        mean, covariance = np.empty(STATES), np.empty((STATES, STATES))
        merge(means, covariances, weights, mean, covariance)
        return TargetTrack(t_s, mean[:3].copy(), mean[3:6].copy(), covariance[:6, :6].copy(), t_s - float(ring.measured_s[slot]))

    def _refilter(self, slot: int) -> None:
        ring, parameters = self._ring, self._parameters
        refilter(
            slot,
            len(self._measurements) + 1,
            ring.t_s,
            ring.measured_s,
            ring.rows,
            ring.lengths,
            ring.named,
            ring.means,
            ring.covariances,
            ring.weights,
            ring.rejections,
            ring.fits,
            self._models,
            self._turning,
            GATES_TOLD,
            GATES_SEEN,
            parameters.unknown_speed_sigma_m_s,
            parameters.rejections_max,
            parameters.gap_max_s,
            parameters.seen_spread_max_m,
        )
