"""From a measurement on, everything after it is filtered again: the part of the target filter that costs time, compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.estimation.measurement import ROW_LENGTH, ROWS_MAX
from flightapp.estimation.multiple_models import STATES, TURN_RATE, advance, correct, merge
from perception.kernel_cache import njit

GATES_TOLD = np.array([0.0, 10.83, 13.82, 16.27, 18.47, 20.52, 22.46])
"""99.9 % of the squared Mahalanobis distance, by degrees of freedom: what the evader says is rarely doubted."""
GATES_SEEN = np.array([0.0, 6.63, 9.21, 11.34, 13.28, 15.09, 16.81])
"""99 %: what a camera saw may be something else."""
USED, LEFT_OUT, STARTED = 1, 0, 2

_F8, _I8 = numba.types.float64, numba.types.int64
_F8_1, _F8_2, _F8_3, _F8_4, _I8_1 = _F8[::1], _F8[:, ::1], _F8[:, :, ::1], _F8[:, :, :, ::1], _I8[::1]


@dataclass(frozen=True, slots=True)
class Ring:
    """Measurements in order of time and the estimate after each. Slot 0 is what is left of all that is older; n slots, m models.

    t_s: (n,), measured_s: (n,) time of the newest measurement used, nan before the track starts. rows: (n, 6, 8). lengths: (n,)
    rows in use. named: (n,) 0 or 1. means: (n, m, 7), covariances: (n, m, 7, 7), weights: (n, m). rejections: (n,) of named
    measurements in a row. fits: (n, 3) USED, LEFT_OUT or STARTED; squared Mahalanobis distance; distance of the position, m.
    """

    t_s: Array
    measured_s: Array
    rows: Array
    lengths: NDArray[np.int64]
    named: NDArray[np.int64]
    means: Array
    covariances: Array
    weights: Array
    rejections: NDArray[np.int64]
    fits: Array

    def open(self, place: int, count: int) -> None:
        """Make room at `place`: the `count` slots in use from there on move up by one."""
        self._move(place + 1, place, count - place)

    def drop_oldest(self, count: int) -> None:
        """The estimate after the oldest measurement becomes what is left of all that is older."""
        self._move(0, 1, count - 1)

    def _move(self, to: int, start: int, number: int) -> None:
        for column in (
            self.t_s,
            self.measured_s,
            self.rows,
            self.lengths,
            self.named,
            self.means,
            self.covariances,
            self.weights,
            self.rejections,
            self.fits,
        ):
            column[to : to + number] = column[start : start + number].copy()


def make_ring(slots: int, models: int) -> Ring:
    """An empty ring: no track in slot 0."""
    return Ring(
        t_s=np.full(slots, -math.inf),
        measured_s=np.full(slots, math.nan),
        rows=np.zeros((slots, ROWS_MAX, ROW_LENGTH)),
        lengths=np.zeros(slots, np.int64),
        named=np.zeros(slots, np.int64),
        means=np.zeros((slots, models, STATES)),
        covariances=np.zeros((slots, models, STATES, STATES)),
        weights=np.zeros((slots, models)),
        rejections=np.zeros(slots, np.int64),
        fits=np.zeros((slots, 3)),
    )


@njit(
    numba.void(_F8_2, _F8_2, _F8_3, _F8_1, _F8_2, _F8_1, _F8),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _start(rows, means, covariances, weights, models, turning, unknown_speed_sigma):  # type: ignore[no-untyped-def]
    """A track from one named measurement: rows of the three axes of the position, perhaps of the velocity."""
    for j in range(means.shape[0]):
        means[j, :] = 0.0
        covariances[j, :, :] = 0.0
        weights[j] = models[j, 2]
        for axis in range(6):
            covariances[j, axis, axis] = unknown_speed_sigma**2
        for k in range(rows.shape[0]):
            means[j, k] = rows[k, 6]
            covariances[j, k, k] = rows[k, 7]
        covariances[j, TURN_RATE, TURN_RATE] = turning[1] ** 2


@njit("UniTuple(f8,2)(f8[:,::1],f8[:,:,::1],f8[::1],f8[:,::1])", cache=True, nogil=True, error_model="numpy")
def _misfit(means, covariances, weights, rows):  # type: ignore[no-untyped-def]
    """Distance of the measured from the predicted position, and the prediction's largest deviation in the plane."""
    mean, covariance = np.empty(STATES), np.empty((STATES, STATES))
    merge(means, covariances, weights, mean, covariance)
    squared = 0.0
    for k in range(min(rows.shape[0], 3)):
        innovation = rows[k, 6]
        for a in range(6):
            innovation -= rows[k, a] * mean[a]
        squared += innovation * innovation
    middle = 0.5 * (covariance[0, 0] + covariance[1, 1])
    half = 0.5 * (covariance[0, 0] - covariance[1, 1])
    return math.sqrt(squared), math.sqrt(middle + math.sqrt(half * half + covariance[0, 1] ** 2))


@njit(
    numba.void(
        _I8, _I8, _F8_1, _F8_1, _F8_3, _I8_1, _I8_1, _F8_3, _F8_4, _F8_2, _I8_1, _F8_2,
        _F8_2, _F8_1, _F8_1, _F8_1, _F8, _I8, _F8, _F8,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def refilter(  # type: ignore[no-untyped-def]
    first,
    count,
    t_s,
    measured_s,
    rows,
    lengths,
    named,
    means,
    covariances,
    weights,
    rejections,
    fits,
    models,
    turning,
    gates_told,
    gates_seen,
    unknown_speed_sigma,
    rejections_max,
    gap_max_s,
    seen_spread_max,
):
    """Estimates of the slots first to count - 1, each from the one before it; arrays as in `Ring`, models as in `advance`."""
    new_means, new_covariances, new_weights = np.empty_like(means[0]), np.empty_like(covariances[0]), np.empty_like(weights[0])
    for i in range(first, count):
        before, mine = i - 1, rows[i, : lengths[i]]
        is_named, has_track = named[i] == 1, not math.isnan(measured_s[before])
        measured_s[i], rejections[i] = measured_s[before], rejections[before]
        means[i], covariances[i], weights[i] = means[before], covariances[before], weights[before]
        fits[i, 0], fits[i, 1], fits[i, 2] = LEFT_OUT, np.nan, np.nan
        if has_track:
            advance(means[i], covariances[i], weights[i], t_s[i] - t_s[before], models, turning)
        if has_track and t_s[i] - measured_s[before] <= gap_max_s:
            fits[i, 2], spread = _misfit(means[i], covariances[i], weights[i], mine)
            new_means[:], new_covariances[:], new_weights[:] = means[i], covariances[i], weights[i]
            fits[i, 1], best = correct(new_means, new_covariances, new_weights, mine)
            if is_named:
                fits[i, 0] = USED if best <= gates_told[lengths[i]] else LEFT_OUT
                rejections[i] = 0 if fits[i, 0] == USED else rejections[before] + 1
            elif fits[i, 1] <= gates_seen[lengths[i]] and spread <= seen_spread_max:
                fits[i, 0] = USED
            if fits[i, 0] == USED:
                means[i], covariances[i], weights[i] = new_means, new_covariances, new_weights
                measured_s[i] = t_s[i]
            elif rejections[i] < rejections_max:
                continue
        if is_named and fits[i, 0] != USED:
            _start(mine, means[i], covariances[i], weights[i], models, turning, unknown_speed_sigma)
            fits[i, 0], measured_s[i], rejections[i] = STARTED, t_s[i], 0
