"""The paper's scenes come out as its text says, and the command writes its table."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import Array
from flightapp.sim.field_study.flight import FieldFlight, fly_scene
from flightapp.sim.field_study.gain_search import FIRST_SEED, SearchSize, cost_of, searched_gains
from flightapp.sim.field_study.methods import METHODS, MOVING_GAINS, STATIC_GAINS, gains_of
from flightapp.sim.field_study.scenes import FieldScene, local_minimum, moving_obstacles, unreachable_target
from flightapp.sim.field_study.search import grey_wolves, random_search
from flightapp.sim.field_study.study import FieldStudy, run_field_study


def fly(scene: FieldScene, name: str, *, literal: bool = False) -> FieldFlight:
    method = METHODS[name]
    return fly_scene(scene, method, gains_of(method, 0.02, STATIC_GAINS, literal=literal), 0.02, 2000, 0)


def test_only_the_goal_aware_field_reaches_a_goal_beside_an_obstacle() -> None:
    conventional = fly(unreachable_target(), "APF")
    assert not conventional.arrived
    assert 0.14 <= conventional.goal_gap_m <= 0.35  # as measured for the specification, section 5
    literal = fly(unreachable_target(), "APF+A", literal=True)
    assert 913 <= literal.steps <= 994
    assert fly(unreachable_target(), "APF+A").arrived


def test_only_the_escape_leaves_a_local_minimum() -> None:
    assert not fly(local_minimum(), "APF+A").arrived
    escaped = fly(local_minimum(), "APF+A+B")
    assert escaped.arrived
    assert escaped.escapes == 1


def test_the_study_is_written_beside_the_printed_figures(tmp_path: Path) -> None:
    small = SearchSize(scenes=2, draws=4, wolves=4, rounds=2)
    study = FieldStudy(tuple(range(10000, 10003)), ("APF", "A-APF", "IAPF-style", "GWO-APF"), search=small)
    finished = run_field_study(study, tmp_path / "apf")
    table, told = (tmp_path / "apf" / "table.md").read_text(), json.loads((tmp_path / "apf" / "apf.json").read_text())
    assert told["random"][0]["flights"] == 3
    for printed in ("91.00", "96.30", "95.70", "95.10", "DDPG-APF"):
        assert printed in table
    assert set(told["searched"]) == {"IAPF-style", "GWO-APF"}
    assert told["searched"]["GWO-APF"]["mean_costs"][-1] == told["searched"]["GWO-APF"]["mean_cost"]
    assert (tmp_path / "apf" / "scenes.png").read_bytes().startswith(b"\x89PNG")
    assert "4 grey wolves, 2 rounds on 2 scenes" in finished.table
    with pytest.raises(InputError, match="APF\\+D"):
        run_field_study(FieldStudy((1,), ("APF+D",)), None)


def test_both_searches_find_the_least_of_a_bowl_within_the_box_and_repeat_themselves() -> None:
    low, high, least = np.array((-1.0, 2.0, 0.0)), np.array((3.0, 4.0, 10.0)), np.array((2.5, 2.2, 7.0))

    def bowl(place: Array) -> float:
        assert (place >= low - 1e-12).all()
        assert (place <= high + 1e-12).all()
        return float(np.square((place - least) / (high - low)).sum())

    pack = grey_wolves(bowl, low, high, 12, 30, 1)
    draws = random_search(bowl, low, high, 12 * 30, 1)
    assert pack.costs[-1] == bowl(pack.place)
    assert list(pack.costs) == sorted(pack.costs, reverse=True)
    assert pack.costs[-1] < 0.5 * draws.costs[-1] < 0.01  # a search that learns is worth its name
    np.testing.assert_array_equal(pack.place, grey_wolves(bowl, low, high, 12, 30, 1).place)
    np.testing.assert_array_equal(draws.place, random_search(bowl, low, high, 12 * 30, 1).place)


def test_what_is_searched_is_what_is_flown_and_a_failure_costs_most() -> None:
    method = METHODS["GWO-APF"]
    values, found = searched_gains(method, 0.0325, 2000, SearchSize(scenes=1, wolves=4, rounds=2), lambda flights: None)
    assert found is not None
    scene = moving_obstacles(FIRST_SEED)
    gains = gains_of(method, 0.0325, MOVING_GAINS, searched=values)
    flight = fly_scene(scene, method, gains, 0.0325, 2000, 0)
    assert cost_of(flight, gains) == found.costs[-1]
    assert flight.arrived
    assert cost_of(flight, gains) < flight.length_m + 5.0 * math.pi + 0.3 * 10.0
    assert cost_of(replace(flight, outcome="collided"), gains) == cost_of(flight, gains) + 100.0
