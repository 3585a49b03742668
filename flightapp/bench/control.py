"""One step of the controller: observer and law."""

from __future__ import annotations

import math

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.control.gains import DEFAULT
from flightapp.control.law import REFERENCE_SIZE, decide
from flightapp.control.observer import STATE_SIZE, observe
from flightapp.core.types import Array

AIM_MS = 0.02


def controller_measurement(seconds: float) -> Measurement:
    """`aadrc-smc` behind a vehicle that weaves around its reference."""
    state, gains, command, nothing = np.zeros(STATE_SIZE), DEFAULT.as_array(), np.zeros(3), np.zeros(3)
    reference = np.zeros(REFERENCE_SIZE)

    def seen(k: int) -> tuple[Array, Array]:
        t_s = 0.02 * k
        return np.array((math.sin(t_s), math.cos(t_s), -5.0)), np.array((math.cos(t_s), -math.sin(t_s), 0.0))

    def act(given: tuple[Array, Array]) -> None:
        observe(state, gains, 0.02, *given)
        decide(state, gains, reference, nothing, command)

    return measure(Work("controller, one step", seen, act, AIM_MS), seconds)
