"""Clearance with heights: that of the plane beside an obstacle, and the way to its edge or face above and below."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.clearance import NO_OBSTACLE_M, clearance_in_space_m, clearance_m

POLE = np.array([[3.0, 4.0, 1.0, 0.0, 0.0, -6.0, 0.0]])
UNKNOWN = np.array([[3.0, 4.0, 1.0, 0.0, 0.0, -math.inf, math.inf]])


@pytest.mark.parametrize(
    ("height_m", "place", "clearance"),
    [
        (5.0, (0.0, 0.0), 3.75),
        (9.0, (0.0, 0.0), 4.75),
        (9.0, (3.0, 4.5), 2.75),
        (9.0, (3.0, 4.0), 2.75),
        (5.0, (3.0, 4.0), -1.25),
    ],
)
def test_beside_above_and_inside(height_m: float, place: tuple[float, float], clearance: float) -> None:
    point = np.array((*place, -height_m))
    assert clearance_in_space_m(point, POLE, 0.25) == pytest.approx(clearance)
    assert clearance_in_space_m(point, UNKNOWN, 0.25) == clearance_m(point[:2], UNKNOWN, 0.25)
    assert clearance_in_space_m(point, POLE[:0], 0.25) == NO_OBSTACLE_M
