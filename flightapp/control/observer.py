"""The extended state observer: position, velocity and disturbance from what is measured and what was really commanded.

Exact discretisation of three equal poles q = exp(-w dt), current observer (specification 2.6). Fed with the modelled, limited
command: an observer that believes in the raw one winds up as soon as the command is limited.
"""

from __future__ import annotations

import math

import numba

from flightapp.control.gains import (
    ACTUATOR,
    DISTURBANCE_MAX,
    OBSERVER,
    OBSERVES_VELOCITY,
    PERIOD,
    RELEASE,
    SCHEDULE,
    SCHEDULE_MAX,
)
from flightapp.core.compiled import compiled
from flightapp.core.types import Array

POSITION, VELOCITY, DISTURBANCE, MODELLED, APPLIED = 0, 3, 6, 9, 12
INNOVATION, SINCE_START, GAP, STARTED = 15, 16, 17, 18
TRACKING = 19
STATE_SIZE = 22
"""A controller's state: five vectors, then the smoothed squared innovation (m^2), seconds since the start, seconds without a
usable measurement, whether it ever was started, and the acceleration that tracking alone wanted."""

LONG_STEPS = 5.0
STEP_CAP_S = 1.0
JUMP_MAX = 5.0
"""Innovation, m (m/s where velocity is observed), beyond which a measurement is not believed."""
FORGET_S = 2.0
"""Time constant with which an unobserved disturbance is forgotten, and the gap after which nothing of it is left."""
BRAKE_AFTER_S = 0.5
INNOVATION_S = 0.2

VECTOR = numba.float64[::1]


@compiled(numba.void(VECTOR, VECTOR, numba.float64))
def _predict(state: Array, gains: Array, dt_s: float) -> None:
    actuator_s = gains[ACTUATOR]
    blend = 1.0 if actuator_s <= 0.0 else 1.0 - math.exp(-dt_s / actuator_s)
    for k in range(3):
        state[MODELLED + k] += blend * (state[APPLIED + k] - state[MODELLED + k])
        pushed = state[DISTURBANCE + k] + state[MODELLED + k]
        state[POSITION + k] += dt_s * state[VELOCITY + k] + 0.5 * dt_s * dt_s * pushed
        state[VELOCITY + k] += dt_s * pushed


@compiled(numba.void(VECTOR, VECTOR, numba.float64, VECTOR, VECTOR, numba.float64))
def _correct(state: Array, gains: Array, gain_s: float, position: Array, velocity: Array, miss: float) -> None:
    """`miss`: squared length of the innovation."""
    state[INNOVATION] += (1.0 - math.exp(-gain_s / INNOVATION_S)) * (miss - state[INNOVATION])
    bandwidth = gains[OBSERVER] * min(1.0 + gains[SCHEDULE] * state[INNOVATION], gains[SCHEDULE_MAX])
    q = math.exp(-min(bandwidth * gain_s, 1.0))
    released = 1.0 if state[SINCE_START] >= gains[RELEASE] else 0.0
    squared = 0.0
    for k in range(3):
        if gains[OBSERVES_VELOCITY] > 0.0:
            off = velocity[k] - state[VELOCITY + k]
            state[POSITION + k] = position[k]
            state[VELOCITY + k] += (1.0 - q * q) * off
            state[DISTURBANCE + k] += released * (1.0 - q) ** 2 / gain_s * off
        else:
            off = position[k] - state[POSITION + k]
            state[POSITION + k] += (1.0 - q**3) * off
            state[VELOCITY + k] += 1.5 * (1.0 - q) ** 2 * (1.0 + q) / gain_s * off
            state[DISTURBANCE + k] += released * (1.0 - q) ** 3 / (gain_s * gain_s) * off
        squared += state[DISTURBANCE + k] ** 2
    if squared > gains[DISTURBANCE_MAX] ** 2:
        for k in range(3):
            state[DISTURBANCE + k] *= gains[DISTURBANCE_MAX] / math.sqrt(squared)


@compiled(numba.void(VECTOR, VECTOR, VECTOR))
def _start(state: Array, position: Array, velocity: Array) -> None:
    """From what is measured now; what is known of the disturbance outlives a short gap."""
    for k in range(3):
        state[POSITION + k] = position[k]
        state[VELOCITY + k] = velocity[k] if math.isfinite(velocity[k]) else 0.0
        if state[GAP] > FORGET_S:
            state[DISTURBANCE + k] = 0.0
    state[GAP], state[INNOVATION], state[STARTED] = 0.0, 0.0, 1.0


@compiled(numba.float64(VECTOR, VECTOR, VECTOR, VECTOR))
def _missed(state: Array, gains: Array, position: Array, velocity: Array) -> float:
    """Squared length of the innovation; infinite where nothing usable was measured."""
    squared = 0.0
    for k in range(3):
        off = position[k] - state[POSITION + k]
        if gains[OBSERVES_VELOCITY] > 0.0:
            off = velocity[k] - state[VELOCITY + k] + 0.0 * position[k]
        squared += off * off
    return squared if math.isfinite(squared) else math.inf


@compiled(numba.void(VECTOR, VECTOR, numba.float64, VECTOR, VECTOR))
def observe(state: Array, gains: Array, dt_s: float, position: Array, velocity: Array) -> None:
    """Move `state` (STATE_SIZE,) on by `dt_s` and correct it by the measured position and velocity, (3,) each.

    A position that is not finite counts as not measured; a velocity that is not finite likewise where velocity is observed. A
    measurement far from the expectation is left out until it has stayed so for BRAKE_AFTER_S; then the observer starts anew. A
    time step that is not positive is ignored: duplicates, and stamps that go back.
    """
    if not dt_s > 0.0:
        return
    left_s, nominal_s = min(dt_s, STEP_CAP_S), gains[PERIOD]
    miss = _missed(state, gains, position, velocity)
    if state[STARTED] == 0.0 or gains[OBSERVER] <= 0.0 or state[GAP] > BRAKE_AFTER_S:
        state[GAP] += left_s
        if miss < math.inf:
            _start(state, position, velocity)
        return
    gain_s = min(max(left_s, 0.5 * nominal_s), 2.0 * nominal_s)
    passed_s, step_s = left_s, nominal_s if left_s > LONG_STEPS * nominal_s else left_s
    while left_s > 0.0:
        _predict(state, gains, min(step_s, left_s))
        left_s -= step_s
    state[SINCE_START] += passed_s
    miss = _missed(state, gains, position, velocity)
    if miss <= JUMP_MAX * JUMP_MAX:
        state[GAP] = 0.0
        _correct(state, gains, gain_s, position, velocity, miss)
        return
    state[GAP] += passed_s
    for k in range(3):
        state[DISTURBANCE + k] *= math.exp(-passed_s / FORGET_S)
