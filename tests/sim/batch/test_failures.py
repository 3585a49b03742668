"""Pursuers that fail: silent, undeciding and gone; and what encirclement, formation and travel are measured to be."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.planning.capture import forms_polygon
from flightapp.sim.batch import fly, load_scenario
from flightapp.sim.batch.families.layout import Start
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.surrounding import measure_encirclement
from tests.sim.batch.stubs import SCENARIOS, command, scenario, world
from tests.sim.batch.test_episode import Kept, bits

FAILS = """
extends = "{forest}"
time_limit_s = 4.0
[layout]
discs = 2
[[failures]]
vehicle = "p2"
t_s = 1.0
[[failures]]
vehicle = "random"
t_s = 2.0
"""


def failing(folder: Path) -> Scenario:
    path = folder / "fails.toml"
    path.write_text(FAILS.format(forest=SCENARIOS / "forest.toml"))
    return load_scenario(path)


def test_who_failed_is_silent_does_nothing_and_is_forgotten(tmp_path: Path) -> None:
    flown, kept = failing(tmp_path), Kept()
    result = fly(flown, "geo-apf", 1, watcher=kept)
    assert result.lost == 2
    for t_s, observations, decisions, truth in zip(kept.t_s, kept.observations, kept.decisions, kept.truth, strict=True):
        mate = next(member for member in observations[0].team if member.name == "p2")
        assert mate.age_s == pytest.approx(max(0.0, t_s - 0.9), abs=1e-6)
        assert (decisions[1].mode == "lost") == (t_s > 0.99)
        if t_s > 0.99:
            assert (truth.states[1].position_ned_m == kept.truth[10].states[1].position_ned_m).all()
            assert "p2" not in [member.name for member in observations[-1].team]
    assert bits(result) == bits(fly(flown, "geo-apf", 1))


def test_who_failed_is_touched_by_nobody_and_encircles_nobody() -> None:
    here = world(scenario("forest", pursuers__count=2), [Start(0.0, 0.0, 0.0), Start(1.0, 0.0, 0.0)], Start(1.5, 0.0, 0.0), [])
    here.remove(1)
    for tick in range(12):
        outcome = here.advance(tick, [command(1.0, 0.0), command(0.0, 0.0), command(0.9, 0.0)])
        assert outcome == 0
    assert math.isinf(here.record["separation"][0])


@pytest.mark.parametrize(
    ("vehicle", "sentence"),
    [
        ("p9", "failures.vehicle = 'p9': pursuers.count = 7; name p1 to p7"),
        ("leader", "failures.vehicle = 'leader': nobody leads; set messages.assignment = true"),
        ("evader", "vehicle"),
    ],
)
def test_a_failure_that_cannot_be_is_one_sentence(tmp_path: Path, vehicle: str, sentence: str) -> None:
    path = tmp_path / "fails.toml"
    path.write_text(FAILS.replace('"p2"', f'"{vehicle}"').format(forest=SCENARIOS / "forest.toml"))
    with pytest.raises(InputError) as refusal:
        load_scenario(path)
    assert sentence in str(refusal.value)


@pytest.mark.parametrize(
    ("bearings_deg", "encircled"),
    [((0, 120, 240), True), ((0, 90, 179), False), ((0, 180), False), ((0, 180, 90), False), ((0, 181, 90), True)],
)
def test_encircled_is_inside_the_hull(bearings_deg: tuple[int, ...], encircled: bool) -> None:
    starts = [Start(3.0 * math.cos(math.radians(b)), 3.0 * math.sin(math.radians(b)), 0.0) for b in bearings_deg]
    here = world(scenario("forest", pursuers__count=len(starts)), starts, Start(0.0, 0.0, 0.0), [])
    assert bool(here.record["encircled"][0]) == encircled
    here.remove(0)
    measure_encirclement(here.record, here.vehicles, 1.0, 1.0)
    assert not here.record["encircled"][0]


def test_a_single_integrator_flies_what_it_is_told_at_once_and_no_faster() -> None:
    here = world(scenario("forest", pursuers__count=1), [Start(0.0, 0.0, 0.0)], Start(50.0, 0.0, 0.0), [])
    for tick, (north, east) in enumerate([(0.6, 0.8), (0.0, -3.0)]):
        here.advance(tick, [command(north, east), command(0.0, 0.0)])
    assert here.vehicles[0]["n"] == pytest.approx(0.06)
    assert here.vehicles[0]["e"] == pytest.approx(0.08 - 0.1)
    assert here.vehicles[0]["turning"] == pytest.approx(math.pi - (math.pi / 2.0 - math.atan2(0.8, 0.6)))


@settings(max_examples=30, deadline=None)
@given(st.integers(3, 8), st.floats(-math.pi, math.pi), st.integers(0, 7), st.floats(0.0, 2.0))
def test_a_regular_polygon_however_turned_is_a_formation_until_one_corner_leaves(
    count: int, turned_rad: float, which: int, off_m: float
) -> None:
    bearings = turned_rad + np.arange(count) * 2.0 * math.pi / count
    bearings = np.arctan2(np.sin(bearings), np.cos(bearings))[::-1].copy()
    distances = np.full(count, 10.0)
    distances[which % count] += off_m
    if abs(off_m - 1.0) > 1e-6:
        assert forms_polygon(bearings, distances, 10.0, 1.0, math.radians(15.0)) == (off_m < 1.0)


def test_two_and_the_uneven_are_no_formation() -> None:
    assert not forms_polygon(np.array([0.0, math.pi]), np.full(2, 10.0), 10.0, 5.0, 3.0)
    assert not forms_polygon(np.radians([0.0, 100.0, 240.0]), np.full(3, 10.0), 10.0, 5.0, math.radians(15.0))
