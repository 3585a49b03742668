from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import NO_OBSTACLE_M, clearance_m, closest_approach_m, disc_clearances_m, gap_m, way_gap_m

place = st.tuples(st.floats(-50, 50), st.floats(-50, 50)).map(np.array)
discs = st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(0, 5)), min_size=1, max_size=8).map(np.array)


@settings(max_examples=200, deadline=None)
@given(place, discs, st.floats(0, 2))
def test_clearance_is_the_gap_between_surfaces(point: np.ndarray, rows: np.ndarray, body: float) -> None:
    gaps = [math.dist(point, row[:2]) - row[2] - body for row in rows]
    assert disc_clearances_m(point, rows, body) == pytest.approx(gaps)
    assert [gap_m(*(row[:2] - point), row[2] + body) for row in rows] == pytest.approx(gaps)
    assert clearance_m(point, rows, body) == pytest.approx(min(gaps))


def test_overlap_is_negative_and_an_empty_world_is_far() -> None:
    assert clearance_m(np.zeros(2), np.array([[0.0, 0.0, 1.0]]), 0.5) == -1.5
    assert clearance_m(np.zeros(2), np.zeros((0, 7)), 0.5) == NO_OBSTACLE_M


@settings(max_examples=200, deadline=None)
@given(place, place, st.floats(0, 2))
def test_the_gap_on_a_way_is_the_least_along_it(start: np.ndarray, end: np.ndarray, reach: float) -> None:
    exact = way_gap_m(*start, *(end - start), reach)
    assert exact == pytest.approx(closest_approach_m(start, end)[0] - reach, abs=1e-9)
    sampled = min(gap_m(*(start + f * (end - start)), reach) for f in np.linspace(0, 1, 101))
    assert exact <= sampled + 1e-9
    assert sampled <= exact + float(np.linalg.norm(end - start)) / 200 + 1e-9


@settings(max_examples=200, deadline=None)
@given(place, place)
def test_closest_approach_lies_on_the_segment(start: np.ndarray, end: np.ndarray) -> None:
    distance, fraction = closest_approach_m(start, end)
    assert 0.0 <= fraction <= 1.0
    assert distance == pytest.approx(float(np.linalg.norm(start + fraction * (end - start))))
    assert distance <= min(np.linalg.norm(start), np.linalg.norm(end)) + 1e-9


def test_closest_approach_of_a_standstill() -> None:
    assert closest_approach_m(np.array([3.0, 4.0]), np.array([3.0, 4.0])) == (5.0, 0.0)
