from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flightapp.analysis.path_study.study import PAPER, Study, run_study
from flightapp.analysis.path_study.tracking import fly
from flightapp.analysis.path_study.trial import GAP_M, LIMITS, run_trial
from flightapp.cli import app
from flightapp.core.errors import InputError
from flightapp.planning.path_planning.trajectory import timed
from flightapp.space.random_scene import random_scene


def test_a_trial_measures_the_way_that_is_flown() -> None:
    trial, way = run_trial("rrt-star-apf", random_scene(11), 11, 2000, 0.1)
    assert trial.found
    assert not trial.direct
    assert trial.flyable
    assert GAP_M - 0.01 <= trial.clearance_m < 4.0
    assert trial.flown_clearance_m >= trial.clearance_m - trial.error_m - 0.05
    assert 1.0 < trial.detour < 1.1
    assert trial.length_m == pytest.approx(float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()), rel=2e-3)
    assert trial.planning_s < trial.whole_s


def test_a_way_that_asks_too_much_is_seen_to_be_no_flight() -> None:
    corner = np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 20.0, 0.0]])
    gentle, harsh = timed(corner, LIMITS), timed(corner, LIMITS).slowed(3.0)
    assert fly(gentle, 6.0).error_m < 1.0
    assert fly(harsh, 6.0).error_m > 3.0
    assert fly(harsh, 6.0).limited > 0.2


def test_the_study_writes_a_table_every_trial_and_pictures(tmp_path: Path) -> None:
    found = run_study(Study(("rrt-star-apf",), (3,), iterations=300), tmp_path / "study")
    assert "rrt-star-apf" in found.table
    every = json.loads((found.folder / "trials.json").read_text())
    assert len(every["trials"]) == 10
    blocked = [one for one in every["trials"] if one["scene"].startswith("paper") and not one["direct"]]
    assert every["figures"][PAPER]["rrt-star-apf"]["scenes"] == len(blocked) > 3
    assert len(list(found.folder.glob("paper-*.png"))) == 3
    with pytest.raises(InputError, match="is not empty"):
        run_study(Study(("rrt-star-apf",), (3,)), found.folder)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--planner", "a-star"], "--planner a-star: no such path planner"),
        (["--obstacles", "40"], "--obstacles 40: must lie between 0 and 25"),
        (["--seeds", "9-3"], "--seeds 9-3"),
    ],
)
def test_bad_input_is_one_sentence(arguments: list[str], said: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["campaign", "paths", "--out", str(tmp_path / "new"), *arguments])
    assert said in str(result.exception)
    assert not (tmp_path / "new").exists()
