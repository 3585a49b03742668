"""Interacting multiple models: several motions are believed in at once, each as far as the measurements speak for it.

Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking and Navigation (2001), 11.6.6. All models share the state
north, east, down, their velocities, and the turn rate about the vertical (rad/s, clockwise seen from above). A model that flies
straight has no turn rate of its own: it lends the prior's to the mixture.

Motion may change at any time: within dt it does with probability 1 - exp(-rate dt), and then the new model is drawn by the
prior's probabilities. So the models' probabilities after two steps are those after one step of the same length in all.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from perception.kernel_cache import njit

STATES = 7
TURN_RATE = 6
STEP_S = 0.1
"""Longest step between two mixings: over a longer one a change of motion would come too late into the prediction."""
STEPS_MAX = 100
SLOW_TURN_RAD = 1e-4
"""Below this angle a turn's sine and cosine are taken from their series."""
WEIGHT_MIN = 1e-6
"""No model is ever given up for good."""

_F8 = numba.types.float64
_F8_1, _F8_2, _F8_3 = _F8[::1], _F8[:, ::1], _F8[:, :, ::1]


@njit(numba.void(_F8_2, _F8, _F8), cache=True, nogil=True, error_model="numpy")
def _add_acceleration(covariance, dt, density):  # type: ignore[no-untyped-def]
    """White acceleration of power density `density` on each axis over `dt`."""
    for axis in range(3):
        covariance[axis, axis] += density * dt**3 / 3.0
        covariance[axis, 3 + axis] += density * dt**2 / 2.0
        covariance[3 + axis, axis] += density * dt**2 / 2.0
        covariance[3 + axis, 3 + axis] += density * dt


@njit(numba.void(_F8_2, _F8_2, _F8_2), cache=True, nogil=True, error_model="numpy")
def _carry(covariance, motion, scratch):  # type: ignore[no-untyped-def]
    """covariance <- motion covariance motion', kept symmetric."""
    for i in range(STATES):
        for j in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += motion[i, k] * covariance[k, j]
            scratch[i, j] = total
    for i in range(STATES):
        for j in range(i, STATES):
            total = 0.0
            for k in range(STATES):
                total += scratch[i, k] * motion[j, k]
            covariance[i, j] = covariance[j, i] = total


@njit(numba.void(_F8_1, _F8_2, _F8, _F8_1, _F8_1, _F8_2), cache=True, nogil=True, error_model="numpy")
def _move(mean, covariance, dt, model, turning, scratch):  # type: ignore[no-untyped-def]
    """One model over one step. model: see `models`; turning: see `advance`."""
    motion = np.zeros((STATES, STATES))
    for i in range(STATES):
        motion[i, i] = 1.0
    motion[2, 5] = dt
    sigma, time = turning[1], turning[2]
    if model[0] == 0.0:
        motion[0, 3] = motion[1, 4] = dt
        motion[TURN_RATE, TURN_RATE] = 0.0
        mean[0] += dt * mean[3]
        mean[1] += dt * mean[4]
        mean[TURN_RATE] = 0.0
        fresh = sigma * sigma
    else:
        rate = mean[TURN_RATE]
        angle = rate * dt
        if abs(angle) < SLOW_TURN_RAD:
            ahead, aside = dt, rate * dt * dt / 2.0
            ahead_by_rate, aside_by_rate = -rate * dt**3 / 3.0, dt * dt / 2.0
        else:
            ahead, aside = math.sin(angle) / rate, (1.0 - math.cos(angle)) / rate
            ahead_by_rate = (math.cos(angle) * dt - ahead) / rate
            aside_by_rate = (math.sin(angle) * dt - aside) / rate
        cos, sin = math.cos(angle), math.sin(angle)
        north, east = mean[3], mean[4]
        motion[0, 3], motion[0, 4] = ahead, -aside
        motion[1, 3], motion[1, 4] = aside, ahead
        motion[3, 3], motion[3, 4] = cos, -sin
        motion[4, 3], motion[4, 4] = sin, cos
        motion[0, TURN_RATE] = north * ahead_by_rate - east * aside_by_rate
        motion[1, TURN_RATE] = north * aside_by_rate + east * ahead_by_rate
        motion[3, TURN_RATE] = -dt * (sin * north + cos * east)
        motion[4, TURN_RATE] = dt * (cos * north - sin * east)
        mean[0] += ahead * north - aside * east
        mean[1] += aside * north + ahead * east
        mean[3], mean[4] = cos * north - sin * east, sin * north + cos * east
        kept = math.exp(-dt / time)
        motion[TURN_RATE, TURN_RATE] = kept
        mean[TURN_RATE] = kept * rate
        fresh = sigma * sigma * (1.0 - kept * kept)
    mean[2] += dt * mean[5]
    _carry(covariance, motion, scratch)
    covariance[TURN_RATE, TURN_RATE] += fresh
    _add_acceleration(covariance, dt, model[1])


@njit(numba.void(_F8_2, _F8_3, _F8_1, _F8, _F8_2, _F8_2, _F8_3, _F8_1), cache=True, nogil=True, error_model="numpy")
def _mix(means, covariances, weights, stay, models, old_means, old_covariances, old_weights):  # type: ignore[no-untyped-def]
    """What each model starts its step from: a mixture of all, by who may have become it. `stay`: probability of no change."""
    number = means.shape[0]
    old_means[:], old_covariances[:], old_weights[:] = means, covariances, weights
    for j in range(number):
        weights[j] = (1.0 - stay) * models[j, 2] + stay * old_weights[j]
        for a in range(STATES):
            total = 0.0
            for i in range(number):
                came = old_weights[i] * ((1.0 - stay) * models[j, 2] + (stay if i == j else 0.0)) / weights[j]
                total += came * old_means[i, a]
            means[j, a] = total
        for a in range(STATES):
            for b in range(a, STATES):
                total = 0.0
                for i in range(number):
                    came = old_weights[i] * ((1.0 - stay) * models[j, 2] + (stay if i == j else 0.0)) / weights[j]
                    away = (old_means[i, a] - means[j, a]) * (old_means[i, b] - means[j, b])
                    total += came * (old_covariances[i, a, b] + away)
                covariances[j, a, b] = covariances[j, b, a] = total


@njit(numba.void(_F8_2, _F8_3, _F8_1, _F8, _F8_2, _F8_1), cache=True, nogil=True, error_model="numpy")
def advance(means, covariances, weights, dt, models, turning):  # type: ignore[no-untyped-def]
    """Carry (m, 7), (m, 7, 7), (m,) on by `dt` in place.

    models: (m, 3) rows 1 for a turn else 0, acceleration density m2/s3, prior probability. turning: (3,) rate of changes 1/s,
    standard deviation of the turn rate rad/s, and the time in which a turn is forgotten, s.
    """
    if dt <= 0.0:
        return
    number = means.shape[0]
    steps = min(max(1, math.ceil(dt / STEP_S)), STEPS_MAX)
    step_s = dt / steps
    stay = math.exp(-turning[0] * step_s)
    scratch = np.empty((STATES, STATES))
    old_means, old_covariances, old_weights = np.empty_like(means), np.empty_like(covariances), np.empty_like(weights)
    for _ in range(steps):
        if number > 1:
            _mix(means, covariances, weights, stay, models, old_means, old_covariances, old_weights)
        for j in range(number):
            _move(means[j], covariances[j], step_s, models[j], turning, scratch)


@njit(numba.void(_F8_2, _F8_3, _F8_1, _F8_1, _F8_2), cache=True, nogil=True, error_model="numpy")
def merge(means, covariances, weights, mean, covariance):  # type: ignore[no-untyped-def]
    """The mixture's mean (7,) and covariance (7, 7)."""
    number = means.shape[0]
    for a in range(STATES):
        total = 0.0
        for j in range(number):
            total += weights[j] * means[j, a]
        mean[a] = total
    for a in range(STATES):
        for b in range(a, STATES):
            total = 0.0
            for j in range(number):
                total += weights[j] * (covariances[j, a, b] + (means[j, a] - mean[a]) * (means[j, b] - mean[b]))
            covariance[a, b] = covariance[b, a] = total


@njit("UniTuple(f8,2)(f8[::1],f8[:,::1],f8[:,::1],f8[::1])", cache=True, nogil=True, error_model="numpy")
def _correct_one(mean, covariance, rows, gain):  # type: ignore[no-untyped-def]
    """Kalman's correction with one scalar after the other; returns squared Mahalanobis distance and log likelihood."""
    distance, likelihood = 0.0, 0.0
    for k in range(rows.shape[0]):
        innovation, spread = rows[k, 6], rows[k, 7]
        for a in range(6):
            innovation -= rows[k, a] * mean[a]
        for a in range(STATES):
            total = 0.0
            for b in range(6):
                total += covariance[a, b] * rows[k, b]
            gain[a] = total
        for a in range(6):
            spread += rows[k, a] * gain[a]
        distance += innovation * innovation / spread
        likelihood -= 0.5 * (math.log(2.0 * math.pi * spread) + innovation * innovation / spread)
        for a in range(STATES):
            mean[a] += gain[a] * innovation / spread
            for b in range(a, STATES):
                covariance[a, b] -= gain[a] * gain[b] / spread
                covariance[b, a] = covariance[a, b]
    return distance, likelihood


@njit("UniTuple(f8,2)(f8[:,::1],f8[:,:,::1],f8[::1],f8[:,::1])", cache=True, nogil=True, error_model="numpy")
def correct(means, covariances, weights, rows):  # type: ignore[no-untyped-def]
    """Take in a measurement (k, 8) (see measurement.Row) in place.

    Returns the squared Mahalanobis distance of the measurement to the mixture, and to the model that it fits best.
    """
    number = means.shape[0]
    gain, mean, covariance = np.empty(STATES), np.empty(STATES), np.empty((STATES, STATES))
    merge(means, covariances, weights, mean, covariance)
    merged, _ = _correct_one(mean, covariance, rows, gain)
    likelihoods = np.empty(number)
    best = np.inf
    for j in range(number):
        distance, likelihoods[j] = _correct_one(means[j], covariances[j], rows, gain)
        best = min(best, distance)
    most, total = likelihoods.max(), 0.0
    for j in range(number):
        weights[j] = max(weights[j] * math.exp(likelihoods[j] - most), WEIGHT_MIN)
        total += weights[j]
    for j in range(number):
        weights[j] /= total
    return merged, best
