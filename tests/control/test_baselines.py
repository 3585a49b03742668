"""The controllers that ours is compared with: limited whatever comes in, no wind-up, and what each is there to show."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.control.cascade import SUM as CASCADE_SUM
from flightapp.control.cascade import CascadeGains, decide_cascade
from flightapp.control.printed import PRINTED, SUM, TUNED_PID, PrintedGains, decide_printed
from flightapp.core.types import Array

KERNELS: dict[str, tuple[Callable[..., None], PrintedGains | CascadeGains]] = {
    **{name: (decide_printed, gains) for name, gains in PRINTED.items()},
    "pid tuned": (decide_printed, TUNED_PID),
    "px4": (decide_cascade, CascadeGains()),
}
STATE_SIZE = 32
NUMBER = st.sampled_from([0.0, 1.0, -2.5, 40.0, -1e9, 1e200, math.nan, math.inf])


def vectors(count: int) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(*[NUMBER] * count)


@pytest.mark.parametrize("name", KERNELS)
@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(vectors(3), vectors(3), vectors(9), vectors(3)), min_size=1, max_size=3))
def test_every_command_is_finite_and_limited(name: str, steps: list[tuple[tuple[float, ...], ...]]) -> None:
    kernel, gains = KERNELS[name]
    state, command = np.zeros(STATE_SIZE), np.zeros(3)
    for step in steps:
        kernel(state, gains.as_array(), 0.02, *(np.array(vector) for vector in step), command)
        assert np.isfinite(command).all()
        assert np.linalg.norm(command) <= 6.0 * (1.0 + 1e-9)


def held(name: str, gains: PrintedGains | CascadeGains, error_m: float, seconds: float) -> Array:
    """The state after a vehicle has been kept `error_m` from where it is to be."""
    kernel, _ = KERNELS[name]
    state, command, reference = np.zeros(STATE_SIZE), np.zeros(3), np.zeros(9)
    reference[0] = error_m
    for _ in range(round(seconds / 0.02)):
        kernel(state, gains.as_array(), 0.02, np.zeros(3), np.zeros(3), reference, np.zeros(3), command)
    return state


def test_no_integral_grows_while_the_command_is_limited() -> None:
    near, far = held("pid tuned", TUNED_PID, 0.5, 1.0), held("pid tuned", TUNED_PID, 30.0, 5.0)
    assert abs(near[SUM]) == pytest.approx(0.5, rel=0.05), "within the limit it does"
    assert abs(far[SUM]) < 0.7
    winding = held("pid tuned", replace(TUNED_PID, conditional=0.0), 30.0, 5.0)
    assert abs(winding[SUM]) > 90.0, "the unsafe twin"
    quick = CascadeGains()
    assert held("px4", quick, 1.0, 1.0)[CASCADE_SUM] > 0.1
    assert held("px4", quick, 30.0, 5.0)[CASCADE_SUM] == 0.0


def flown(name: str, push_m_s2: float, seconds: float) -> tuple[float, float]:
    """Where a vehicle that is pushed ends, m from its place, at 100 Hz without lag; and the share of limited commands."""
    kernel, gains = KERNELS[name]
    state, command, position, velocity = np.zeros(STATE_SIZE), np.zeros(3), np.zeros(3), np.zeros(3)
    limited, steps = 0, round(seconds / 0.01)
    for _ in range(steps):
        kernel(state, gains.as_array(), 0.01, position, velocity, np.zeros(9), np.zeros(3), command)
        limited += np.linalg.norm(command) > 5.99
        velocity = velocity + 0.01 * (command + np.array((push_m_s2, 0.0, 0.0)))
        position = position + 0.01 * velocity
    return float(np.linalg.norm(position)), limited / steps


def test_px4_s_loops_take_out_a_steady_push_and_the_printed_gains_are_a_relay() -> None:
    error_m, limited = flown("px4", 1.5, 30.0)
    assert error_m < 0.02
    assert limited == 0.0
    assert flown("smc", 1.5, 10.0)[1] > 0.9
