"""How a pursuit ends."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.types import Boundary
from flightapp.runtime.outcome import Outcome, crosses, outcome_of_team

LINE = Boundary(np.array([[0.0, -30.0], [0.0, 30.0]]), closed=False)
coordinate = st.floats(-20.0, 20.0)


@given(coordinate, coordinate, coordinate, coordinate)
def test_a_line_is_crossed_exactly_when_the_sign_of_north_changes(n0: float, e0: float, n1: float, e1: float) -> None:
    if abs(n0) > 1e-6 and abs(n1) > 1e-6:
        assert crosses(LINE, np.array([n0, e0]), np.array([n1, e1])) == (n0 * n1 < 0.0)


@given(st.floats(0.0, 2 * math.pi), st.floats(0.0, 4.0), st.floats(8.0, 20.0))
def test_going_into_a_closed_area_crosses_its_edge_and_staying_outside_does_not(
    bearing: float, inside_m: float, outside_m: float
) -> None:
    square = Boundary(np.array([[-5.0, -5.0], [-5.0, 5.0], [5.0, 5.0], [5.0, -5.0]]), closed=True)
    toward = np.array([math.cos(bearing), math.sin(bearing)])
    assert crosses(square, outside_m * toward, inside_m * toward)
    assert not crosses(square, outside_m * toward, 1.5 * outside_m * toward)


def test_a_gap_beside_an_open_line_is_free() -> None:
    assert not crosses(LINE, np.array([5.0, 40.0]), np.array([-5.0, 40.0]))


def test_a_capture_told_by_one_vehicle_counts_for_all_and_an_abort_does_not() -> None:
    assert outcome_of_team([None, "aborted", "captured"]) is Outcome.CAPTURED
    assert outcome_of_team(["aborted", "fault", None]) is None
    assert outcome_of_team([]) is None
