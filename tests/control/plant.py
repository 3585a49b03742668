"""A vehicle for closed loops: a double integrator with actuator lag, delay and a constant push."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from flightapp.control.gains import Gains
from flightapp.control.law import REFERENCE_SIZE, decide
from flightapp.control.observer import APPLIED, DISTURBANCE, STATE_SIZE, observe
from flightapp.core.types import Array

NOTHING = np.zeros(3)


@dataclass(slots=True)
class Story:
    """What one closed loop came to."""

    overshoot_share: float = 0.0
    """Beyond the goal, of the step."""
    error_m: float = 0.0
    """At the end."""
    excess_m_s2: float = 0.0
    """Largest estimate of the disturbance beyond the true one."""
    command_max_m_s2: float = 0.0


def fly_step(
    gains: Gains,
    start_m: Array,
    push: Array,
    lag_s: float,
    delay_s: float,
    seconds: float,
    *,
    fed_raw: bool = False,
    periods_s: Array | None = None,
) -> Story:
    """From rest at `start_m` (3,) to the origin. fed_raw: the observer is told the command that tracking wanted, unlimited.

    periods_s: the control periods, one by one; without them `seconds` of the nominal one.
    """
    state, flat, told = np.zeros(STATE_SIZE), gains.as_array(), np.zeros(3)
    position, velocity, flown, reference = start_m.astype(np.float64), np.zeros(3), np.zeros(3), np.zeros(REFERENCE_SIZE)
    step_s = gains.period_s / max(4, math.ceil(gains.period_s / 0.01))
    wire = deque([np.zeros(3)] * (round(delay_s / step_s) + 1), maxlen=round(delay_s / step_s) + 1)
    blend = 1.0 - math.exp(-step_s / lag_s)
    size = float(np.linalg.norm(start_m))
    towards = -start_m / size
    story = Story()
    for period_s in [gains.period_s] * round(seconds / gains.period_s) if periods_s is None else periods_s.tolist():
        parts = max(1, round(period_s / step_s))
        observe(state, flat, period_s, position, velocity)
        decide(state, flat, reference, NOTHING, told)
        if fed_raw:
            state[APPLIED : APPLIED + 3] = state[19:22]
        story.excess_m_s2 = max(
            story.excess_m_s2, float(np.linalg.norm(state[DISTURBANCE : DISTURBANCE + 3]) - np.linalg.norm(push))
        )
        story.command_max_m_s2 = max(story.command_max_m_s2, float(np.linalg.norm(told)))
        for _ in range(parts):
            wire.append(told.copy())
            flown += blend * (wire[0] - flown)
            acceleration = flown + push
            position = position + step_s * velocity + 0.5 * step_s * step_s * acceleration
            velocity = velocity + step_s * acceleration
            story.overshoot_share = max(story.overshoot_share, float(position @ towards) / size)
    story.error_m = float(np.linalg.norm(position))
    return story
