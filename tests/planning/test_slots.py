"""Slots around the evader: one order for all pursuers, equal spacing, moved only as far as the encirclement allows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
from flightapp.core.bearing import wrapped_rad
from flightapp.core.types import Limits
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import parameter_record
from flightapp.planning.ac2f.slots import free_slot_bearing_rad, slack_rad, slot_bearing_rad
from flightapp.planning.plane import Point
from tests.planning import pursuit_reference as reference

EVADER = (30.0, 0.0)
coordinate = st.floats(-20.0, 20.0).map(lambda value: round(value, 3) + 0.0)
pursuers = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=6, unique=True)
disc = st.tuples(st.floats(26.0, 34.0), st.floats(-4.0, 4.0), st.floats(0.0, 3.0))


def bearings(team: list[Point]) -> list[float]:
    """The slot of each, as each of them computes it with itself in front."""
    return [slot_bearing_rad(*EVADER, np.array([own, *[p for p in team if p != own]])) for own in team]


@given(pursuers)
def test_every_pursuer_finds_the_same_equally_spaced_slots(team: list[Point]) -> None:
    spread = sorted(bearings(team))
    gaps = [(b - a) % (2 * math.pi) for a, b in zip(spread, [*spread[1:], spread[0]], strict=True)]
    if len(team) > 1:
        assert gaps == pytest.approx([2 * math.pi / len(team)] * len(team))
    for own, expected in zip(bearings(team), reference.slot_bearings(EVADER, team), strict=True):
        assert math.cos(own - expected) == pytest.approx(1.0, abs=1e-12)


@given(st.lists(disc, max_size=8), st.floats(-3.1, 3.1), st.floats(0.0, 3.1))
def test_a_free_slot_is_found_as_in_plain_python(discs: list[tuple[float, float, float]], bearing: float, slack: float) -> None:
    scene = np.array(discs).reshape(-1, 3)
    expected = reference.free_slot_bearing(scene, EVADER, reference.Slot(bearing, 2.2, 0.0), slack)
    found = free_slot_bearing_rad(scene, *EVADER, 2.2, bearing, slack, 0.3)
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("count", range(1, 8))
def test_one_pursuer_off_its_slot_by_the_slack_keeps_the_encirclement(count: int) -> None:
    record = parameter_record(Ac2fParameters(), Limits(6.0, 6.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45))
    slack = slack_rad(record, count)
    assert slack == pytest.approx(reference.slack_rad(count, 90.0))
    if count == 2:
        assert math.pi - 2.0 * slack >= math.radians(90.0)
    if count > 2:
        assert 2.0 * math.pi / count + 2.0 * slack < math.pi or slack == 0.0


@given(st.floats(-20.0, 20.0))
def test_bearings_wrap_as_elsewhere(angle: float) -> None:
    assert wrapped_rad(angle) == pytest.approx(wrap_pi(angle), abs=1e-12) or abs(wrapped_rad(angle)) > math.pi - 1e-9
