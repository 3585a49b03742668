from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.angles import bearing_rad, wrap_pi


@given(st.floats(-1e6, 1e6))
def test_wrapping_keeps_the_direction_and_the_half_open_interval(angle: float) -> None:
    wrapped = wrap_pi(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-6)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-6)
    assert wrap_pi(wrapped) == wrapped


@pytest.mark.parametrize("angle", [math.pi, -math.pi])
def test_half_a_turn_is_positive(angle: float) -> None:
    assert wrap_pi(angle) == math.pi


@pytest.mark.parametrize(("vector", "degrees"), [((1, 0), 0), ((0, 1), 90), ((-1, 0), 180), ((-1, -0.0), 180), ((0, -1), -90)])
def test_bearings_run_clockwise_from_north(vector: tuple[float, float], degrees: float) -> None:
    assert bearing_rad(*vector) == pytest.approx(math.radians(degrees))
