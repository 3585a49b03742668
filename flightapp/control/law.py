"""`aadrc-smc`: from the observed state and the reference to a limited acceleration (specification 2.6).

Baselines are the same law with a part left out: without the sliding-mode term it is ADRC, without the observer SMC.
"""

from __future__ import annotations

import math

import numba

from flightapp.control.gains import (
    ACCELERATION_MAX,
    BRAKING_SHARE,
    CORRECTION_MAX,
    DERIVATIVE,
    LAYER,
    PROPORTIONAL,
    SWITCHING,
    TILT_MAX,
    VERTICAL_MAX,
)
from flightapp.control.observer import APPLIED, BRAKE_AFTER_S, DISTURBANCE, GAP, POSITION, TRACKING, VECTOR, VELOCITY
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

GRAVITY_M_S2 = 9.80665
REFERENCE_SIZE = 9
"""Position, velocity and acceleration to be flown."""
DECIDES = numba.void(VECTOR, VECTOR, numba.float64, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR)
"""Of a baseline's kernel `decide_x(state, gains, dt_s, position, velocity, reference, avoidance, command)`, one control period.

position, velocity, avoidance (an acceleration), command (3,); reference (REFERENCE_SIZE,). It writes `command`, an acceleration
limited in length, and `state`, which begins as zeros.
"""


@compiled(numba.float64(numba.float64, VECTOR))
def return_speed(error_m: float, gains: Array) -> float:
    """Speed with which an error of position is taken out: linear near the reference, braking at a constant rate far from it.

    The square root is what keeps a limited acceleration from overshooting: 30 m step, 6.4 m of overshoot without, none with it.
    """
    slope = gains[PROPORTIONAL] / gains[DERIVATIVE]
    braking = gains[BRAKING_SHARE] * gains[ACCELERATION_MAX]
    linear_m = braking / (slope * slope)
    speed = slope * error_m if error_m < linear_m else math.sqrt(2.0 * braking * (error_m - 0.5 * linear_m))
    limited: float = min(speed, gains[CORRECTION_MAX])
    return limited


@compiled(numba.float64(numba.float64))
def known(value: float) -> float:
    """`value`, or zero where it is none."""
    return value if abs(value) < math.inf else 0.0


@compiled(numba.boolean(VECTOR, VECTOR, numba.float64))
def shortened(vector: Array, out: Array, limit: float) -> bool:
    """out (3,): `vector` at most `limit` long, zero where it is no number; whether that made a difference."""
    squared = 0.0
    for k in range(3):
        out[k] = known(vector[k])
        squared += out[k] * out[k]
    if squared <= limit * limit:
        return False
    scale = limit / math.sqrt(squared)
    for k in range(3):
        out[k] *= scale
    return True


@compiled(numba.void(VECTOR, VECTOR, VECTOR, numba.float64))
def limited_sum(first: Array, second: Array, out: Array, limit: float) -> None:
    """out (3,): `first`, limited in length, and as much of `second` in its direction as the limit leaves room for."""
    shortened(first, out, limit)
    squared = second[0] ** 2 + second[1] ** 2 + second[2] ** 2
    if squared <= 0.0:
        return
    along = out[0] * second[0] + out[1] * second[1] + out[2] * second[2]
    room = max(0.0, limit * limit - (out[0] ** 2 + out[1] ** 2 + out[2] ** 2))
    root = math.sqrt(along * along + squared * room)
    share = room / (root + along) if along > 0.0 else (root - along) / squared
    share = min(1.0, max(0.0, known(share)))
    for k in range(3):
        out[k] += share * second[k]


@compiled(numba.void(VECTOR, numba.float64))
def leaned(command: Array, tilt_max_rad: float) -> None:
    """Shorten the planar part of an acceleration (3,), NED, until a multirotor leans no more than `tilt_max_rad` for it."""
    planar = math.sqrt(command[0] ** 2 + command[1] ** 2)
    room = max(0.0, math.tan(tilt_max_rad) * (GRAVITY_M_S2 - command[2]))
    if planar > room:
        command[0] *= room / planar
        command[1] *= room / planar


@compiled(numba.void(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR))
def decide(state: Array, gains: Array, reference: Array, avoidance: Array, command: Array) -> None:
    """command (3,): acceleration, at most `acceleration_max`, no steeper than `tilt_max`; noted in `state` as what was told.

    reference (9,): a position that is not finite is not tracked, the velocity alone is then. avoidance (3,) goes first.
    Without a measurement for BRAKE_AFTER_S the vehicle brakes. Whatever else is not finite counts as zero.
    """
    error = 0.0
    for k in range(3):
        error += (state[POSITION + k] - reference[k]) ** 2
    error = math.sqrt(error)
    lost = state[GAP] > BRAKE_AFTER_S
    pull = 0.0
    if math.isfinite(error) and error > 1e-9 and not lost:
        pull = return_speed(error, gains) / error
    squared = 0.0
    for k in range(3):
        sliding = state[VELOCITY + k]
        if not lost:
            sliding -= known(reference[3 + k])
        if pull > 0.0:
            sliding += pull * (state[POSITION + k] - reference[k])
        state[TRACKING + k] = sliding
        squared += sliding * sliding
    gain = gains[DERIVATIVE] + gains[SWITCHING] / max(gains[LAYER], math.sqrt(squared))
    for k in range(3):
        forward = 0.0 if lost else known(reference[6 + k])
        state[TRACKING + k] = forward - gain * state[TRACKING + k] - state[DISTURBANCE + k]
    state[TRACKING + 2] = min(gains[VERTICAL_MAX], max(-gains[VERTICAL_MAX], state[TRACKING + 2]))
    limited_sum(avoidance, state[TRACKING : TRACKING + 3], command, gains[ACCELERATION_MAX])
    leaned(command, gains[TILT_MAX])
    for k in range(3):
        state[APPLIED + k] = command[k]
