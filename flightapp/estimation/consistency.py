"""Does the target filter's covariance tell the truth? Judged on a recorded flight under the network and the sight of a chase.

NEES: normalised estimation error squared, of position and velocity together (Bar-Shalom, Li, Kirubarajan 2001, 5.4.2). Of a
consistent filter its mean is 6, and 95 % of the errors lie inside the covariance's 95 % ellipsoid. The errors of a track follow
from each other, so one error a second is counted as independent for the bounds of the mean.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.stats import chi2

from flightapp.core.errors import InputError
from flightapp.core.types import Array, TargetTrack
from flightapp.estimation.measurement import Measurement, seen, told
from flightapp.estimation.sighting_noise import sighting_sigma_m
from flightapp.estimation.target_filter import MotionModel, TargetFilter, TargetFilterParameters

AHEAD_S = (0.25, 0.5, 1.0)
TICK_S = 0.04
INDEPENDENT_PER_S = 1.0
SETTLED_S = 1.0
"""The first second is the filter's to find the velocity."""
TOLD_SIGMA = (0.1, 0.2)
"""m and m/s, of what the evader tells."""

CONSTANT_VELOCITY = TargetFilterParameters(models=(MotionModel(False, 2.0, 1.0),))
"""One model, white acceleration: what was flown with before."""


@dataclass(frozen=True, slots=True)
class Flight:
    """A recorded flight, mission frame NED, from time 0."""

    name: str
    duration_s: float
    position: BSpline
    velocity: BSpline

    def truth(self, t_s: float) -> Array:
        """(6,) position and velocity."""
        return np.concatenate((self.position(t_s), self.velocity(t_s)))


@dataclass(frozen=True, slots=True)
class Circumstances:
    """What reaches a vehicle: telemetry of the evader at `told_rate_hz` (0: none), sightings of cameras at `cameras`."""

    told_rate_hz: float = 20.0
    seen_rate_hz: float = 10.0
    cameras: tuple[tuple[float, float], ...] = ((12.0, -10.0), (12.0, 10.0))
    loss: float = 0.15
    delay_min_s: float = 0.02
    delay_max_s: float = 0.3
    occlusion_period_s: float = 8.0
    """From the start of one occlusion to that of the next; they last 1 to 2 s, and nothing is told or seen meanwhile."""


@dataclass(frozen=True, slots=True)
class Consistency:
    """Of one flight and one filter. Where `hidden`, during occlusions; else outside them."""

    flight: str
    nees: float
    nees_bounds: tuple[float, float]
    """95 % of the mean of a consistent filter."""
    inside: float
    """Share of errors inside the 95 % ellipsoid."""
    nees_hidden: float
    inside_hidden: float
    nis: float
    """Mean, per measured scalar; 1 of a consistent filter."""
    position_rms_m: float
    velocity_rms_m_s: float
    ahead_rms_m: tuple[float, ...]
    """Of the position AHEAD_S ahead of now."""


def read_flight(path: Path, slowed: float = 1.0) -> Flight:
    """A flight from `timestamp,tx,ty,tz,...` lines with z up; flown `slowed` times slower. InputError says what is wrong."""
    try:
        rows = np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1, 2, 3), ndmin=2)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise InputError(f"{path}: {error}; lines must read timestamp,x,y,z,... in s and m with z up, after one header") from None
    if len(rows) < 20 or not np.isfinite(rows).all() or (np.diff(rows[:, 0]) <= 0.0).any():
        raise InputError(f"{path}: {len(rows)} lines; at least 20 with finite numbers and rising time are needed")
    t_s = (rows[:, 0] - rows[0, 0]) * slowed
    position = make_interp_spline(t_s, rows[:, 1:] * (1.0, -1.0, -1.0), k=5)
    return Flight(path.stem, float(t_s[-1]), position, position.derivative())


def judge(
    flight: Flight, parameters: TargetFilterParameters | None = None, circumstances: Circumstances | None = None, seed: int = 0
) -> Consistency:
    """Feed a filter as a vehicle would, in order of arrival, and compare it with the truth at every control period."""
    circumstances = Circumstances() if circumstances is None else circumstances
    random = np.random.default_rng(seed)
    hidden = _occlusions(flight.duration_s, circumstances, random)
    arrivals = measurements_of(flight, circumstances, hidden, random)
    heapq.heapify(arrivals)
    target = TargetFilter(parameters)
    errors: list[tuple[bool, float, Array]] = []
    ahead: list[list[float]] = [[] for _ in AHEAD_S]
    nis: list[float] = []
    for tick in range(int(flight.duration_s / TICK_S)):
        now_s = tick * TICK_S
        while arrivals and arrivals[0][0] <= now_s:
            measurement = heapq.heappop(arrivals)[1]
            fit = target.take(measurement)
            if fit is not None and math.isfinite(fit.nis):
                nis.append(fit.nis / len(measurement.rows))
        track = target.predict(now_s)
        if track is None or now_s < SETTLED_S:
            continue
        error = np.concatenate((track.position_ned_m, track.velocity_ned_m_s)) - flight.truth(now_s)
        errors.append((_is_hidden(now_s, hidden), _nees(error, track), error))
        for of, ahead_s in zip(ahead, AHEAD_S, strict=True):
            later = target.predict(now_s + ahead_s)
            if later is not None and now_s + ahead_s <= flight.duration_s:
                of.append(float(np.sum((later.position_ned_m - flight.truth(now_s + ahead_s)[:3]) ** 2)))
    return _judged(flight.name, errors, ahead, nis)


def measurements_of(
    flight: Flight, circumstances: Circumstances, hidden: Sequence[tuple[float, float]], random: np.random.Generator
) -> list[tuple[float, Measurement]]:
    """(time of arrival, measurement) of everything that is not lost, in no particular order."""
    out: list[tuple[float, Measurement]] = []

    def send(measurement: Measurement | None) -> None:
        delay_s = random.uniform(circumstances.delay_min_s, circumstances.delay_max_s)
        if measurement is not None and random.random() >= circumstances.loss and not _is_hidden(measurement.t_s, hidden):
            out.append((measurement.t_s + delay_s, measurement))

    for t_s in _times(circumstances.told_rate_hz, flight.duration_s):
        noisy = flight.truth(t_s) + random.normal(size=6) * np.repeat(TOLD_SIGMA, 3)
        send(told(t_s, noisy[:3], noisy[3:], *TOLD_SIGMA))
    for north_m, east_m in circumstances.cameras:
        for t_s in _times(circumstances.seen_rate_hz, flight.duration_s):
            at_north, at_east = flight.truth(t_s)[:2].tolist()
            bearing, distance = math.atan2(at_east - east_m, at_north - north_m), math.hypot(at_east - east_m, at_north - north_m)
            sigma = sighting_sigma_m(distance)
            along, across = random.normal() * sigma[0], random.normal() * sigma[1]
            cos, sin = math.cos(bearing), math.sin(bearing)
            send(seen(t_s, at_north + along * cos - across * sin, at_east + along * sin + across * cos, bearing, *sigma))
    return out


def _times(rate_hz: float, duration_s: float) -> Array:
    return np.arange(0.0, duration_s, 1.0 / rate_hz) if rate_hz > 0.0 else np.zeros(0)


def _occlusions(duration_s: float, circumstances: Circumstances, random: np.random.Generator) -> list[tuple[float, float]]:
    starts = np.arange(circumstances.occlusion_period_s, duration_s - 2.0, circumstances.occlusion_period_s)
    return [(float(start), float(start) + random.uniform(1.0, 2.0)) for start in starts]


def _is_hidden(t_s: float, hidden: Sequence[tuple[float, float]]) -> bool:
    return any(start <= t_s < end for start, end in hidden)


def _nees(error: Array, track: TargetTrack) -> float:
    return float(error @ np.linalg.solve(track.covariance, error))


def _judged(name: str, errors: list[tuple[bool, float, Array]], ahead: list[list[float]], nis: list[float]) -> Consistency:
    limit = float(chi2.ppf(0.95, 6))
    open_nees = np.array([nees for is_hidden, nees, _ in errors if not is_hidden])
    hidden_nees = np.array([nees for is_hidden, nees, _ in errors if is_hidden])
    independent = max(1, round(len(open_nees) * TICK_S * INDEPENDENT_PER_S))
    low, high = (float(chi2.ppf(share, 6 * independent)) / independent for share in (0.025, 0.975))
    squared = np.array([error**2 for _, _, error in errors])
    return Consistency(
        flight=name,
        nees=float(open_nees.mean()),
        nees_bounds=(low, high),
        inside=float((open_nees <= limit).mean()),
        nees_hidden=float(hidden_nees.mean()) if len(hidden_nees) else math.nan,
        inside_hidden=float((hidden_nees <= limit).mean()) if len(hidden_nees) else math.nan,
        nis=float(np.mean(nis)),
        position_rms_m=math.sqrt(float(squared[:, :3].sum(axis=1).mean())),
        velocity_rms_m_s=math.sqrt(float(squared[:, 3:].sum(axis=1).mean())),
        ahead_rms_m=tuple(math.sqrt(float(np.mean(of))) for of in ahead),
    )
