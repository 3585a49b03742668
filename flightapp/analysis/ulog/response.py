"""Setpoint against achieved velocity: error and delay of the response."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.analysis.ulog import modes
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.spans import Mask, Span, within
from flightapp.core.types import Array

STEP_S = 0.02
DELAY_MAX_S = 2.0
SPREAD_MIN_M_S = 0.1
"""A setpoint that hardly changes tells no delay."""
SHARE_MIN = 0.5
"""Of the samples in flight that must ask for a velocity."""
SAMPLES_MIN = 20
_VELOCITY = ("vx", "vy", "vz")
_SOURCES = (
    ("trajectory_setpoint", ("velocity[0]", "velocity[1]", "velocity[2]")),
    ("vehicle_local_position_setpoint", _VELOCITY),
)


@dataclass(frozen=True, slots=True)
class Response:
    """`delay_s`: how far the velocity follows behind its setpoint, and the error left then; None where it cannot be told."""

    source: str
    span: Span
    t_s: Array  # (n,)
    wanted_m_s: Array  # (n, 3) NED
    achieved_m_s: Array  # (n, 3) NED
    rms_horizontal_m_s: float
    rms_vertical_m_s: float
    delay_s: float | None
    rms_delayed_m_s: float | None


def response_of(log: FlightLog) -> Response | None:
    """Over the time in offboard, or in the air where offboard was not flown; None where no velocity was asked for.

    The outer setpoint (trajectory_setpoint) is used where it asks for a velocity, else the position controller's.
    """
    local = log.topic("vehicle_local_position")
    achieved = None if local is None else local.vectors(_VELOCITY)
    spans = log.in_mode(modes.OFFBOARD) or log.airborne()
    if local is None or achieved is None or not spans:
        return None
    for name, columns in _SOURCES:
        topic = log.topic(name)
        wanted = None if topic is None else topic.vectors(columns)
        if topic is None or wanted is None:
            continue
        inside = within(topic.t_s, spans)
        asked = inside & np.isfinite(wanted).all(axis=1)
        if asked.sum() >= max(SAMPLES_MIN, SHARE_MIN * inside.sum()) and _moves(wanted[asked]):
            return _response(name, topic, wanted, asked, local, achieved)
    return None


def _moves(wanted: Array) -> bool:
    return bool(np.linalg.norm(wanted.std(axis=0)) >= SPREAD_MIN_M_S)


def _response(name: str, topic: Topic, wanted: Array, asked: Mask, local: Topic, achieved: Array) -> Response:
    first, last = float(topic.t_s[asked][0]), float(topic.t_s[asked][-1])
    t_s = np.arange(first, last, STEP_S)
    # A setpoint holds until the next one comes.
    held = np.clip(np.searchsorted(topic.t_s[asked], t_s, side="right") - 1, 0, None)
    setpoint = wanted[asked][held]
    flown = _resampled(t_s, local.t_s, achieved)
    error = flown - setpoint
    delay_s, rms_delayed = _delay(t_s, setpoint, local.t_s, achieved)
    return Response(
        source=name,
        span=Span(first, last),
        t_s=t_s,
        wanted_m_s=setpoint,
        achieved_m_s=flown,
        rms_horizontal_m_s=_rms(error[:, :2]),
        rms_vertical_m_s=_rms(error[:, 2:]),
        delay_s=delay_s,
        rms_delayed_m_s=rms_delayed,
    )


def _delay(t_s: Array, setpoint: Array, times: Array, achieved: Array) -> tuple[float | None, float | None]:
    """The shift that leaves the least horizontal error; None at the end of the range, where there is no minimum."""
    if np.linalg.norm(setpoint[:, :2].std(axis=0)) < SPREAD_MIN_M_S:
        return None, None
    delays = np.arange(0.0, DELAY_MAX_S, STEP_S)
    errors = [_rms(_resampled(t_s + delay, times, achieved)[:, :2] - setpoint[:, :2]) for delay in delays]
    best = int(np.argmin(errors))
    return (None, None) if best == len(delays) - 1 else (float(delays[best]), errors[best])


def _resampled(t_s: Array, times: Array, vectors: Array) -> Array:
    return np.column_stack([np.interp(t_s, times, vectors[:, axis]) for axis in range(vectors.shape[1])])


def _rms(error: Array) -> float:
    """Root of the mean square length of the rows."""
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
