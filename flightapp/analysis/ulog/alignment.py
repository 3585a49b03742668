"""Two recorders of one flight, each with its own clock: offset and drift, from the velocity that both recorded.

Velocity needs no common origin, and it is the same estimate on both sides: PX4's. What is found includes the time that the
velocity took from the estimator into our recording (the telemetry link); the two cannot be told apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import least_squares
from scipy.signal import correlate

from flightapp.analysis.ulog.spans import Mask
from flightapp.core.types import Array

STEP_S = 0.05
OVERLAP_MIN_S = 10.0
"""Shorter stretches match by chance."""
MOTION_MIN_M_S = 0.1
"""RMS of the changes of velocity; a vehicle that stands or hovers has nothing to match."""
CORRELATION_MIN = 0.8
RIVAL_S, RIVAL_MAX = 2.0, 0.97
"""A match this far off that is this good beside the best: a periodic motion, ambiguous."""
DRIFT_SIGMA_MAX_PPM = 100.0
"""Drift that is known worse than this is not estimated: quartz clocks differ by less."""
ROBUST_M_S = 0.05
SLOPE_S = 0.02
SMOOTH_S, SMOOTH_STEP_S = 0.1, 0.01
_GAP_MAX_S = 1.0


@dataclass(frozen=True, slots=True)
class Motion:
    """Velocity NED (n, 3) in m/s at times (n,) in s that increase."""

    t_s: Array
    velocity_ned_m_s: Array


@dataclass(frozen=True, slots=True)
class Alignment:
    """`to_reference(t)` = t + offset_s + drift * (t - middle_s). Sigmas are standard deviations."""

    offset_s: float
    """Of the reference's clock against the log's, at `middle_s` of the log."""
    offset_sigma_s: float
    drift_ppm: float
    """0 where the common stretch is too short to tell; its sigma is None then."""
    drift_sigma_ppm: float | None
    middle_s: float
    overlap_s: float
    correlation: float
    residual_m_s: float

    def to_reference(self, t_s: Array | float) -> Array | float:
        """Times of the log as times of the reference."""
        return t_s + self.offset_s + 1e-6 * self.drift_ppm * (t_s - self.middle_s)


def align(reference: Motion, log: Motion) -> Alignment | str:
    """The clock of `log` against that of `reference`; a clause that says why not where they cannot be matched."""
    grids = [_grid(reference), _grid(log)]
    if any(len(t_s) * STEP_S < OVERLAP_MIN_S for t_s, _ in grids):
        return f"less than {OVERLAP_MIN_S:g} s of velocity were recorded"
    if any(float(np.sqrt(np.mean(np.sum(np.diff(v, axis=0) ** 2, axis=1)) / STEP_S)) < MOTION_MIN_M_S for _, v in grids):
        return "the vehicle hardly moved"
    coarse = _coarse(*grids[0], *grids[1])
    if isinstance(coarse, str):
        return coarse
    fitted = _fine(reference, log, *coarse, with_drift=True)
    if isinstance(fitted, Alignment) and (fitted.drift_sigma_ppm or 0.0) > DRIFT_SIGMA_MAX_PPM:
        return _fine(reference, log, *coarse, with_drift=False)
    return fitted


def _grid(motion: Motion) -> tuple[Array, Array]:
    t_s = np.arange(motion.t_s[0], motion.t_s[-1], STEP_S)
    return t_s, _at(motion, t_s)


def _at(motion: Motion, t_s: Array) -> Array:
    return np.column_stack([np.interp(t_s, motion.t_s, motion.velocity_ned_m_s[:, axis]) for axis in range(3)])


def _coarse(reference_s: Array, reference: Array, log_s: Array, log: Array) -> tuple[float, float] | str:
    """(offset, correlation) of the best of all lags, each scored over what overlaps then."""
    product = sum(correlate(reference[:, axis], log[:, axis]) for axis in range(3))
    energy_reference = correlate(np.sum(reference**2, axis=1), np.ones(len(log)))
    energy_log = correlate(np.ones(len(reference)), np.sum(log**2, axis=1))
    count = np.round(correlate(np.ones(len(reference)), np.ones(len(log))))
    # Half of all that moved must take part, else an edge that matches by chance wins.
    whole = min(float(np.sum(reference**2)), float(np.sum(log**2)))
    fair = (count * STEP_S >= OVERLAP_MIN_S) & (np.minimum(energy_reference, energy_log) >= 0.5 * whole)
    score = np.where(fair, product / np.sqrt(np.maximum(energy_reference * energy_log, 1e-12)), -1.0)
    best = int(np.argmax(score))
    if score[best] < CORRELATION_MIN:
        return f"no common motion was found (correlation {score[best]:.2f}, wanted {CORRELATION_MIN:g})"
    far = np.abs(np.arange(len(score)) - best) * STEP_S > RIVAL_S
    if far.any() and score[far].max() > RIVAL_MAX * score[best]:
        return "the motion repeats itself: more than one offset fits"
    lag_s = (best - (len(log) - 1)) * STEP_S
    return float(reference_s[0] - log_s[0] + lag_s), float(score[best])


def _fine(reference: Motion, log: Motion, offset_s: float, correlation: float, *, with_drift: bool) -> Alignment | str:
    """Robust least squares over the samples of the log that the reference spans."""
    lasting = _covered(reference, log.t_s + offset_s)
    t_s, wanted = log.t_s[lasting], _at(_smooth(log), log.t_s[lasting])
    known = _smooth(reference)
    if len(t_s) < 10 or t_s[-1] - t_s[0] < OVERLAP_MIN_S:
        return f"less than {OVERLAP_MIN_S:g} s were recorded by both"
    middle_s = float(0.5 * (t_s[0] + t_s[-1]))
    half_s = float(0.5 * (t_s[-1] - t_s[0]))
    share = (t_s - middle_s) / half_s

    def shifted(unknowns: Array) -> Array:
        return np.asarray(t_s + offset_s + unknowns[0] + (unknowns[1] * share if with_drift else 0.0), dtype=np.float64)

    def residuals(unknowns: Array) -> Array:
        left: Array = _at(known, shifted(unknowns)) - wanted
        return left.ravel()

    def slopes(unknowns: Array) -> Array:
        times = shifted(unknowns)
        slope = (_at(known, times + SLOPE_S) - _at(known, times - SLOPE_S)) / (2.0 * SLOPE_S)
        columns = [slope, slope * share[:, None]] if with_drift else [slope]
        return np.column_stack([column.ravel() for column in columns])

    start = np.zeros(2 if with_drift else 1)
    found = least_squares(residuals, start, slopes, loss="soft_l1", f_scale=ROBUST_M_S, x_scale=0.01)
    left = residuals(found.x)
    sigma = _sigmas(slopes(found.x), left.reshape(-1, 3))
    return Alignment(
        offset_s=offset_s + float(found.x[0]),
        offset_sigma_s=float(sigma[0]),
        drift_ppm=1e6 * float(found.x[1]) / half_s if with_drift else 0.0,
        drift_sigma_ppm=1e6 * float(sigma[1]) / half_s if with_drift else None,
        middle_s=middle_s,
        overlap_s=2.0 * half_s,
        correlation=correlation,
        residual_m_s=float(np.sqrt(np.mean(left**2))),
    )


def _smooth(motion: Motion) -> Motion:
    """Both sides alike, so that no delay comes of it. Interpolated noise is less between two samples than at one: unsmoothed,
    the fit would be drawn to where the samples of one side lie in the middle between those of the other."""
    t_s = np.arange(motion.t_s[0], motion.t_s[-1], SMOOTH_STEP_S)
    return Motion(t_s, gaussian_filter1d(_at(motion, t_s), SMOOTH_S / SMOOTH_STEP_S, axis=0))


def _covered(reference: Motion, t_s: Array) -> Mask:
    """Which times lie between two samples of the reference that are not far apart, a step inside its ends."""
    after = np.searchsorted(reference.t_s, t_s)
    inside = (t_s > reference.t_s[0] + 0.5) & (t_s < reference.t_s[-1] - 0.5)
    gaps = np.concatenate(([math.inf], np.diff(reference.t_s), [math.inf]))
    return np.asarray(inside & (gaps[after] < _GAP_MAX_S), dtype=np.bool_)


def _sigmas(jacobian: Array, residuals: Array) -> Array:
    """Standard deviations of the unknowns. Residuals that follow each other are alike: fewer of them count."""
    centred = residuals - residuals.mean(axis=0)
    power = float(np.sum(centred**2))
    likeness = float(np.sum(centred[1:] * centred[:-1])) / power if power > 0.0 else 0.0
    likeness = min(max(likeness, 0.0), 0.98)
    variance = float(np.mean(residuals**2)) * (1.0 + likeness) / (1.0 - likeness)
    return np.asarray(np.sqrt(np.maximum(np.diag(np.linalg.pinv(jacobian.T @ jacobian)) * variance, 0.0)), dtype=np.float64)
