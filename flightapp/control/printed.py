"""The controllers of the source as printed, for reproduction only: hybrid, sliding mode, PID, ADRC (specification 2.5 and 3).

None of them should fly: their gains saturate 6 m/s^2 at 2 cm, and with the lag of a real vehicle they swing from limit to limit.
The PID on velocity that the source adds to the tracker is left out: with its printed derivative gain it diverges by itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numba

from flightapp.control.differentiator import differentiate
from flightapp.control.flat import FlatGains
from flightapp.control.law import DECIDES, known, shortened
from flightapp.control.observer import VECTOR
from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@dataclass(frozen=True, slots=True)
class PrintedGains(FlatGains):
    """In the order of the kernel's array; the constants below name the places.

    A zero `differentiator_rad_s` takes the reference as it is, with its velocity and acceleration. Betas of zero: no observer,
    position and velocity are then what was measured. With `schedule_rad_s` the betas follow from a bandwidth that grows with
    the squared error.
    """

    proportional_1_s2: float
    derivative_1_s: float
    integral_1_s3: float = 0.0
    integral_max_m_s: float = 100.0
    conditional: float = 0.0
    """1: the integral stands still while the command is limited."""
    switching_m_s2: float = 0.0
    layer_m_s: float = 0.02
    slope_1_s: float = 35.0
    beta_1_s: float = 0.0
    beta_1_s2: float = 0.0
    beta_1_s3: float = 0.0
    schedule_rad_s: float = 0.0
    schedule_1_m2: float = 2.0
    differentiator_rad_s: float = 20.0
    damping: float = 0.7
    acceleration_max_m_s2: float = 6.0
    fed_limited: float = 1.0
    """0: the observer is fed with the command before limiting."""


(
    PROPORTIONAL,
    DERIVATIVE,
    INTEGRAL,
    INTEGRAL_MAX,
    CONDITIONAL,
    SWITCHING,
    LAYER,
    SLOPE,
    BETA_1,
    BETA_2,
    BETA_3,
    SCHEDULE_W,
    SCHEDULE,
    TD_W,
    TD_ZETA,
    ACCELERATION_MAX,
    FED_LIMITED,
) = range(17)

PRINTED: Mapping[str, PrintedGains] = MappingProxyType(
    {
        "hybrid": PrintedGains(
            300.0, 50.0, switching_m_s2=150.0, beta_1_s=50.0, beta_1_s2=250.0, beta_1_s3=1000.0, schedule_rad_s=30.0
        ),
        "smc": PrintedGains(0.0, 0.0, switching_m_s2=150.0),
        "pid": PrintedGains(500.0, 50.0, 350.0),
        "adrc": PrintedGains(500.0, 350.0, beta_1_s=50.0, beta_1_s2=200.0, beta_1_s3=800.0),
    }
)
TUNED_PID = PrintedGains(4.0, 4.0, 1.0, conditional=1.0, differentiator_rad_s=0.0)
"""Specification 3."""

TD, Z1, Z2, Z3, SUM, TOLD, STARTED, WANTED = 0, 6, 9, 12, 15, 18, 21, 22
STATE_SIZE = 25
"""Differentiator (6), observer (9), integral (3), command of the last step as the observer gets it (3), started, command before
limiting (3)."""
BANDWIDTH_MAX_RAD_S = 1e3


@compiled(numba.void(VECTOR, VECTOR, numba.float64, VECTOR))
def _observe(state: Array, gains: Array, dt_s: float, position: Array) -> None:
    """The printed observer by one explicit step, its scheduled form by its exact discretisation (explicit, it is unstable)."""
    squared = 0.0
    for k in range(3):
        squared += (state[Z1 + k] - state[TD + k]) ** 2
    bandwidth = min(gains[SCHEDULE_W] * (1.0 + gains[SCHEDULE] * squared), BANDWIDTH_MAX_RAD_S)
    q = math.exp(-bandwidth * dt_s)
    for k in range(3):
        pushed = state[Z3 + k] + state[TOLD + k]
        if gains[SCHEDULE_W] > 0.0:
            state[Z1 + k] += dt_s * state[Z2 + k] + 0.5 * dt_s * dt_s * pushed
            state[Z2 + k] += dt_s * pushed
            off = position[k] - state[Z1 + k]
            state[Z1 + k] += (1.0 - q**3) * off
            state[Z2 + k] += 1.5 * (1.0 - q) ** 2 * (1.0 + q) / dt_s * off
            state[Z3 + k] += (1.0 - q) ** 3 / (dt_s * dt_s) * off
        else:
            off = position[k] - state[Z1 + k]
            state[Z1 + k] += dt_s * (state[Z2 + k] + gains[BETA_1] * off)
            state[Z2 + k] += dt_s * (pushed + gains[BETA_2] * off)
            state[Z3 + k] += dt_s * gains[BETA_3] * off


@compiled(DECIDES)
def decide_printed(
    state: Array,
    gains: Array,
    dt_s: float,
    position: Array,
    velocity: Array,
    reference: Array,
    avoidance: Array,
    command: Array,
) -> None:
    """As printed, with the parts that the gains switch on; the interface is `DECIDES`."""
    if state[STARTED] == 0.0:
        state[STARTED] = 1.0
        for k in range(3):
            state[TD + k], state[TD + 3 + k] = reference[k], reference[3 + k]
            state[Z1 + k], state[Z2 + k] = position[k], velocity[k]
    if gains[TD_W] > 0.0:
        differentiate(state[TD : TD + 6], reference[:3], gains[TD_W], gains[TD_ZETA], dt_s)
    else:
        for k in range(6):
            state[TD + k] = reference[k]
    if gains[BETA_1] > 0.0:
        _observe(state, gains, dt_s, position)
    else:
        for k in range(3):
            state[Z1 + k], state[Z2 + k] = position[k], velocity[k]
    for k in range(3):
        error, rate = state[Z1 + k] - state[TD + k], state[Z2 + k] - state[TD + 3 + k]
        sliding = min(1.0, max(-1.0, (rate + gains[SLOPE] * error) / gains[LAYER]))
        wanted = -gains[PROPORTIONAL] * error - gains[DERIVATIVE] * rate - gains[SWITCHING] * sliding - state[Z3 + k]
        wanted -= gains[INTEGRAL] * state[SUM + k]
        if gains[TD_W] <= 0.0:
            wanted += reference[6 + k]
        state[WANTED + k] = known(wanted + avoidance[k])
    limited = shortened(state[WANTED:STATE_SIZE], command, gains[ACCELERATION_MAX])
    for k in range(3):
        state[TOLD + k] = command[k] if gains[FED_LIMITED] > 0.0 else state[WANTED + k]
        if not (limited and gains[CONDITIONAL] > 0.0):
            more = state[SUM + k] + dt_s * (state[Z1 + k] - state[TD + k])
            state[SUM + k] = min(gains[INTEGRAL_MAX], max(-gains[INTEGRAL_MAX], more))
