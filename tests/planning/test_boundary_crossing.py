"""Crossing the protected boundary."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.types import Boundary
from flightapp.planning.plane import crosses, segments

LINE = segments(Boundary(np.array([[0.0, -30.0], [0.0, 30.0]]), closed=False))
SQUARE = segments(Boundary(np.array([[-5.0, -5.0], [-5.0, 5.0], [5.0, 5.0], [5.0, -5.0]]), closed=True))
coordinate = st.floats(-20.0, 20.0)


@given(coordinate, coordinate, coordinate, coordinate)
def test_a_line_is_crossed_exactly_when_the_sign_of_north_changes(n0: float, e0: float, n1: float, e1: float) -> None:
    if abs(n0) > 1e-6 and abs(n1) > 1e-6:
        assert crosses((n0, e0), (n1, e1), LINE) == (n0 * n1 < 0.0)


@given(st.floats(0.0, 2 * math.pi), st.floats(0.0, 4.0), st.floats(8.0, 20.0))
def test_going_into_a_closed_area_crosses_its_edge_and_staying_outside_does_not(
    bearing: float, inside_m: float, outside_m: float
) -> None:
    north, east = math.cos(bearing), math.sin(bearing)
    outside = (outside_m * north, outside_m * east)
    assert crosses(outside, (inside_m * north, inside_m * east), SQUARE)
    assert not crosses(outside, (1.5 * outside[0], 1.5 * outside[1]), SQUARE)


def test_stopping_exactly_on_the_line_is_seen_and_a_gap_beside_it_is_free() -> None:
    assert crosses((5.0, 1.0), (0.0, 1.0), LINE)
    assert not crosses((5.0, 40.0), (-5.0, 40.0), LINE)
