"""The control study: one scene of it, what it is judged by, and bad input."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.core.errors import InputError
from flightapp.sim.control_study.campaign import study_methods, study_settings
from flightapp.sim.control_study.flown import FlownScene, Setting, fly_one, fly_scene
from flightapp.sim.control_study.methods import METHODS, PLANTS, REAL_PLANT
from flightapp.sim.control_study.reference import GAP_M, plan_course
from flightapp.sim.control_study.table import acceptance, as_markdown, rows_of
from flightapp.sim.control_study.trace import error_of, places_of
from flightapp.space.distance import signed_distance

SETTING = Setting("step 2 m, 17 obstacles", duration_s=30.0)


def test_the_courses_of_all_five_keep_off_bodies_and_off_each_other() -> None:
    course = plan_course(10_002, "level", 17, 2.0, 4)
    assert not isinstance(course, str)
    for places in course.references[:, ::20, :3]:
        assert min(signed_distance(course.bodies, *place, 0.0) for place in places.tolist()) > GAP_M - 0.3
    for one in range(5):
        for other in range(one):
            apart = np.linalg.norm(course.references[one, :, :3] - course.references[other, :, :3], axis=1)
            assert apart.min() >= 4.9


def test_ours_is_accepted_and_the_printed_gains_fail_on_a_vehicle_with_lag() -> None:
    scene = fly_scene(SETTING, 10_002, ("hybrid printed", "hybrid tuned"), (REAL_PLANT,))
    printed, ours = scene.flights
    assert ours.succeeded
    assert ours.figures.error_steady_m < 0.4 < printed.figures.error_steady_m
    assert printed.figures.limited_share > 0.9, "as printed it is a relay"
    verdict = acceptance([scene], REAL_PLANT.name)
    assert verdict.accepted
    broken = replace(scene, flights=(printed, replace(ours, pair_min_m=4.4)))
    assert acceptance([broken], REAL_PLANT.name).failed == ("step 2 m, 17 obstacles, seed 10002: pair 4.40 m",)
    table = as_markdown(rows_of([scene, FlownScene("x", 1, "no way", 0.0, 0.0, ())]), verdict.sentence)
    assert "| 99.85 | 2.63 | 5.32 |" in table


def test_an_unknown_way_or_method_is_refused() -> None:
    with pytest.raises(InputError, match="no such method; known: 'hybrid printed', 'smc printed'"):
        study_methods(["hybrid tuned", "magic"])
    with pytest.raises(InputError, match="--way sideways: no such way; known: level, descent, climb"):
        study_settings("sideways", only_first=True)


def test_the_command_writes_tables_figures_and_pictures_and_says_whether_it_is_accepted(tmp_path: Path) -> None:
    methods, folder = ("hybrid printed", "hybrid tuned"), tmp_path / "out"
    options = [text for method in methods for text in ("--method", method)]
    command = ["campaign", "control", "--seeds", "10002", *options, "--workers", "1", "--json", "--out", str(folder)]
    said = CliRunner().invoke(app, command)
    assert said.exit_code == 0, said.output
    assert json.loads(said.stdout)["acceptance"]["met"]
    told = json.loads((folder / "control.json").read_text())
    assert [(row["plant"], row["method"]) for row in told["rows"]] == [
        (plant.name, method) for plant in PLANTS for method in methods
    ]
    ideal_printed, ideal_ours, printed, ours = told["flights"]
    assert ideal_ours["error_steady_m"] < ideal_printed["error_steady_m"] < 0.4, "on its own plant the printed one works"
    assert ours["down_later_m"] < 1.0 < printed["error_max_m"]
    assert ours["lyapunov_5_s"] < 0.1 * ours["lyapunov_start"]
    assert ours["sliding_peak_m_s"] >= ours["sliding_later_m_s"]
    tables = (folder / "tables.md").read_text()
    for heading in ("## Table 1", "## Table 2 (step 2 m", "## Figures 16 to 18", "## Table 2 as printed"):
        assert heading in tables
    for name in ("control", "tracking", "formation"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_the_trace_holds_every_vehicle_and_the_leader_twice() -> None:
    course = plan_course(10_002, "level", 17, 2.0, 4)
    assert not isinstance(course, str)
    _, trace = fly_one(SETTING, 10_002, course, METHODS["hybrid tuned"], REAL_PLANT)
    places = places_of(trace)
    assert places.shape == (1500, 5, 3)
    assert (places[:, 0] == trace[:, 4:7]).all()
    apart = np.linalg.norm(places[:, 1:] - places[:, :1], axis=2)
    assert apart.min() > 4.5
    assert error_of(trace)[300:].max() < 1.0
