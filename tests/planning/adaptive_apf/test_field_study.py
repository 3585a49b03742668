"""The paper's scenes come out as its text says, and the command writes its table."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flightapp.core.errors import InputError
from flightapp.sim.field_study.flight import FieldFlight, fly_scene
from flightapp.sim.field_study.methods import METHODS, STATIC_GAINS, gains_of
from flightapp.sim.field_study.scenes import FieldScene, local_minimum, unreachable_target
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
    finished = run_field_study(FieldStudy(tuple(range(10000, 10003)), ("APF", "A-APF")), tmp_path / "apf")
    assert "91.00" in (tmp_path / "apf" / "table.md").read_text()
    assert json.loads((tmp_path / "apf" / "apf.json").read_text())["random"][0]["flights"] == 3
    assert "96.30" in finished.table
    with pytest.raises(InputError, match="APF\\+D"):
        run_field_study(FieldStudy((1,), ("APF+D",)), None)
