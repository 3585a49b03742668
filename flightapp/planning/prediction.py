"""Where a target will be: polynomials in time through its latest track, extrapolated no faster than it can fly.

Least squares for north and east apart, of one joint degree (CPPPEA, 2.11 of Li et al. 2025; its gradient descent and its "add
terms until the error is minimal" are not used: they diverge or always take the highest degree).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from flightapp.core.types import Array

WINDOW_MIN_S, WINDOW_S, WINDOW_MAX_S = 3.0, 10.0, 30.0
SAMPLE_PERIOD_S = 0.25
NOISE_FLOOR_M = 0.05
"""Residuals below this tell nothing about a manoeuvre."""
MANOEUVRE_RESIDUALS = 3
ONE_TIME_S = 1e-3
"""Stamps nearer than this are of one time: a velocity between them would be noise."""
FUTURE_MAX_S = 1.0
"""Samples with stamps further ahead of now are refused."""


@dataclass(frozen=True, slots=True)
class Fit:
    """North and east as polynomials in u = (t - middle) / half, both in s."""

    coefficients: Array  # (degree + 1, 2), lowest power first
    middle_s: float
    half_s: float
    spread: Array  # (degree + 1, degree + 1): covariance of the coefficients of one axis
    noise_m: float

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1

    def at(self, times_s: Array) -> Array:
        """Places (n, 2) m at `times_s` (n,)."""
        places: Array = self._powers(times_s) @ self.coefficients
        return places

    def deviations_m(self, times_s: Array) -> Array:
        """Standard deviation (n,) of a place at `times_s` (n,), a axis."""
        powers = self._powers(times_s)
        deviations: Array = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", powers, self.spread, powers), 0.0) + self.noise_m**2)
        return deviations

    def _powers(self, times_s: Array) -> Array:
        powers: Array = np.vander((times_s - self.middle_s) / self.half_s, self.degree + 1, increasing=True)
        return powers


@dataclass(frozen=True, slots=True)
class Path:
    """A predicted way at even times, the first of them now."""

    start_s: float
    step_s: float
    places_m: Array  # (n + 1, 2) north, east
    deviations_m: Array  # (n + 1,)

    def heading_rad(self, index: int) -> float | None:
        """Course on arrival at place `index`: of the last step that moved; None where none did."""
        for i in range(index, 0, -1):
            north, east = (self.places_m[i] - self.places_m[i - 1]).tolist()
            if math.hypot(north, east) > 1e-6:
                return math.atan2(east, north)
        return None


def usable(times_s: Array, places_m: Array, now_s: float) -> tuple[Array, Array]:
    """The samples in the order of time: finite, not from the future, of several at one time the last given."""
    fine = np.isfinite(times_s) & np.isfinite(places_m).all(axis=1) & (times_s <= now_s + FUTURE_MAX_S)
    times, places = times_s[fine], places_m[fine]
    order = np.argsort(times, kind="stable")
    times, places = times[order], places[order]
    last = np.append(times[1:] > times[:-1] + ONE_TIME_S, True) if len(times) else np.zeros(0, dtype=bool)
    return times[last], places[last]


def fit_track(times_s: Array, places_m: Array, now_s: float, degrees: tuple[int, ...] = (1, 2)) -> Fit | None:
    """The polynomial of the best of `degrees` through samples (n,), (n, 2); recent ones weigh more. None without samples.

    Degree by AICc, ties to the lower; one sample stands, two give a straight line.
    """
    times, places = usable(times_s, places_m, now_s)
    if len(times) == 0:
        return None
    span_s = float(times[-1] - times[0])
    middle_s, half_s = 0.5 * float(times[-1] + times[0]), 0.5 * span_s if span_s > 0.0 else 1.0
    scale_s = 0.5 * max(span_s, SAMPLE_PERIOD_S)
    weights = np.exp(-(now_s - times) / scale_s / 2.0)
    if len(times) < 3:
        return _fit_of(times, places, weights, middle_s, half_s, len(times) - 1)[0]
    best, best_score = None, math.inf
    for degree in degrees:
        count, terms = 2 * len(times), 2 * (degree + 1) + 1
        if count <= terms + 1:
            continue
        fit, rest = _fit_of(times, places, weights, middle_s, half_s, degree)
        score = count * math.log(rest / count + 1e-6) + 2 * terms + 2 * terms * (terms + 1) / (count - terms - 1)
        if score < best_score - 1e-9:
            best, best_score = fit, score
    return best if best is not None else _fit_of(times, places, weights, middle_s, half_s, 1)[0]


def _fit_of(times: Array, places: Array, weights: Array, middle_s: float, half_s: float, degree: int) -> tuple[Fit, float]:
    """The fit and its weighted sum of squares (m2), the weights' mean being 1."""
    powers = np.vander((times - middle_s) / half_s, degree + 1, increasing=True)
    roots = np.sqrt(weights * len(weights) / weights.sum())
    normal = np.linalg.pinv(powers * roots[:, None])
    coefficients = normal @ (places * roots[:, None])
    rest = float((((powers @ coefficients - places) * roots[:, None]) ** 2).sum())
    freedom = max(1, 2 * (len(times) - degree - 1))
    noise_m = math.sqrt(rest / freedom)
    return Fit(coefficients, middle_s, half_s, noise_m**2 * (normal @ normal.T), noise_m), rest


def predicted_path(
    fit: Fit | None, place_m: Array, now_s: float, step_s: float, steps: int, speed_max_m_s: float, reach_s: float = WINDOW_S
) -> Path:
    """From `place_m` (2,) on, as `fit` moves, each step no longer than `speed_max_m_s` allows.

    Beyond `reach_s` from now straight on with the last velocity: a polynomial knows nothing there. Without a fit it stands.
    """
    if fit is None or fit.degree == 0:
        return Path(now_s, step_s, np.repeat(place_m[None, :], steps + 1, axis=0), np.full(steps + 1, NOISE_FLOOR_M))
    times_s: Array = now_s + step_s * np.arange(steps + 1, dtype=np.float64)
    bent = max(1, min(steps, round(reach_s / step_s)))
    moves = np.diff(fit.at(times_s[: bent + 1]), axis=0)
    lengths = np.hypot(moves[:, 0], moves[:, 1])
    moves *= np.minimum(1.0, speed_max_m_s * step_s / np.maximum(lengths, 1e-12))[:, None]
    moves = np.concatenate((moves, np.repeat(moves[-1:], steps - bent, axis=0)))
    places = np.concatenate((place_m[None, :], place_m + np.cumsum(moves, axis=0)))
    straight_s = now_s + bent * step_s
    deviations = fit.deviations_m(np.minimum(times_s, straight_s))
    slow_m_s = 0.1 * deviations[bent]  # beyond, the velocity's uncertainty adds up
    return Path(now_s, step_s, places, deviations + slow_m_s * np.maximum(0.0, times_s - straight_s))


@lru_cache(maxsize=8)
def _fit_of_samples(times_s: bytes, places_m: bytes, now_s: float) -> Fit | None:
    """As `fit_track`; once for all vehicles of a process that hold the same samples, as in the fast simulator."""
    return fit_track(np.frombuffer(times_s), np.frombuffer(places_m).reshape(-1, 2), now_s)


class TrackHistory:
    """The samples that a prediction is made from: a window that grows while the fit holds, and is cut when the target turns."""

    def __init__(self) -> None:
        self._times_s: list[float] = []
        self._places_m: list[tuple[float, float]] = []
        self._window_s = WINDOW_S
        self._missed = 0
        self._fit: Fit | None = None

    def note(self, t_s: float, place_m: tuple[float, float], now_s: float) -> None:
        """A sample; those not finite, from the future, not newer or too early for the sampling period are passed over."""
        newest = self._times_s[-1] if self._times_s else -math.inf
        if not all(map(math.isfinite, (t_s, *place_m))) or not newest + SAMPLE_PERIOD_S - 1e-6 <= t_s <= now_s + FUTURE_MAX_S:
            return
        self._judge(t_s, place_m, t_s - newest)
        self._times_s.append(t_s)
        self._places_m.append(place_m)
        while self._times_s[0] < t_s - self._window_s - 1e-6:
            self._times_s.pop(0)
            self._places_m.pop(0)
        self._fit = None

    def fit(self, now_s: float) -> Fit | None:
        """The polynomial through what is in the window."""
        if self._fit is None and self._times_s:
            self._fit = _fit_of_samples(np.array(self._times_s).tobytes(), np.array(self._places_m).tobytes(), now_s)
        return self._fit

    def _judge(self, t_s: float, place_m: tuple[float, float], passed_s: float) -> None:
        """Whether the new sample is where the window's samples let it be expected."""
        fit = self.fit(t_s) if len(self._times_s) >= 4 else None
        if fit is None:
            return
        at = np.array([t_s])
        expected, deviation = fit.at(at)[0], float(fit.deviations_m(at)[0])
        is_off = math.dist(expected, place_m) > 3.0 * max(deviation, NOISE_FLOOR_M)
        self._missed = self._missed + 1 if is_off else 0
        if self._missed >= MANOEUVRE_RESIDUALS:
            self._window_s, self._missed = WINDOW_MIN_S, 0
            since = 1 - MANOEUVRE_RESIDUALS  # the first that was off; the new sample is the last
            self._times_s, self._places_m = self._times_s[since:], self._places_m[since:]
        else:
            self._window_s = min(WINDOW_MAX_S, self._window_s + min(passed_s, 1.0))
