"""Between the vehicles: the repulsion and its gain."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.control.formation import FormationGains, adapted_gain, repel

GAINS = FormationGains()
FLAT = GAINS.as_array()
PLACE = st.tuples(*[st.floats(-6.0, 6.0)] * 3)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.floats(0.0, 12.0), st.floats(0.0, 0.5)), min_size=1, max_size=40), st.floats(1.0, 10.0))
def test_the_gain_stays_within_its_bounds_and_returns_once_spacing_is_safe(
    spells: list[tuple[float, float]], gain: float
) -> None:
    for nearest_m, dt_s in spells:
        gain = adapted_gain(FLAT, gain, nearest_m, dt_s)
        assert GAINS.gain_min_m2_s <= gain <= GAINS.gain_max_m2_s
    for _ in range(round(5.0 * GAINS.decay_s / 0.02)):
        gain = adapted_gain(FLAT, gain, 7.0, 0.02)
    assert gain == pytest.approx(GAINS.gain_min_m2_s, abs=0.01 * (GAINS.gain_max_m2_s - GAINS.gain_min_m2_s))


def test_the_gain_grows_where_a_neighbour_is_too_near() -> None:
    assert adapted_gain(FLAT, 1.0, 4.0, 0.1) > 1.0


@settings(max_examples=40, deadline=None)
@given(st.lists(PLACE, min_size=2, max_size=2), st.tuples(st.floats(1.0, 10.0), st.floats(1.0, 10.0)))
def test_two_push_each_other_equally_and_apart(places: list[tuple[float, float, float]], gains: tuple[float, float]) -> None:
    positions, push, other = np.array(places), np.zeros(3), np.zeros(3)
    nearest = repel(FLAT, positions, np.array(gains), 0, push)
    assert repel(FLAT, positions, np.array(gains), 1, other) == nearest
    assert push == pytest.approx(-other, abs=1e-12)
    if nearest > 1e-6:  # Where both are in one place, any direction apart is right.
        assert float(push @ (positions[0] - positions[1])) >= 0.0
    assert np.linalg.norm(push) <= GAINS.correction_max_m_s + 1e-9
    if nearest >= GAINS.range_m:
        assert not push.any()


def test_two_in_one_place_part() -> None:
    push = np.zeros(3)
    positions = np.zeros((2, 3))
    repel(FLAT, positions, np.ones(2), 1, push)
    assert push[0] < 0.0
