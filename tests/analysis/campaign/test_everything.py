"""The table over everything: a run that is cut goes on where it was, what goes wrong is a row, and the table tells all of it."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.analysis.campaign.everything import campaign, episode_row
from flightapp.analysis.campaign.everything.campaign import Table, fly_everything, show_everything
from flightapp.analysis.campaign.everything.choice import choices
from flightapp.analysis.campaign.everything.curves import lines
from flightapp.analysis.campaign.everything.episode_row import Row, flown_row, histogram, quantile_us
from flightapp.analysis.campaign.everything.families import family_tables
from flightapp.analysis.campaign.everything.grid import load_grid
from flightapp.analysis.campaign.everything.ledger import NAME, read_rows
from flightapp.analysis.campaign.everything.table import GLANCES, glance
from flightapp.analysis.campaign.statistics import wilson_interval
from flightapp.analysis.campaign.workers import Workers
from flightapp.cli import main
from flightapp.core.errors import InputError
from flightapp.sim.batch.scenario import Scenario
from tests.analysis.campaign.small import TEXT

GRID = """
planners = ["geo-apf", "apf"]
seeds = "0-3"
[[families]]
name = "Lines"
scenarios = ["small.toml"]
[[families]]
name = "Others"
scenarios = ["other.toml"]
"""
ONE = Workers(1)


@pytest.fixture
def grid_file(tmp_path: Path) -> Path:
    (tmp_path / "small.toml").write_text(TEXT.replace("time_limit_s = 4.0", "time_limit_s = 1.0"))
    (tmp_path / "other.toml").write_text('extends = "small.toml"\n[layout]\ndiscs = 0\n')
    path = tmp_path / "grid.toml"
    path.write_text(GRID)
    return path


def flown(grid_file: Path, seeds: str, again: tuple[str, ...] = ()) -> Table:
    return fly_everything(load_grid(grid_file, (), (), seeds), grid_file.parent / "out", ONE, again)


def without_time(path: Path) -> list[dict[str, object]]:
    return [{k: v for k, v in row.items() if k not in ("cpu_s", "decision_histogram")} for row in read_rows(path)]


def test_a_run_that_was_cut_goes_on_where_it_was(grid_file: Path) -> None:
    whole = flown(grid_file, "0-2")
    ledger = whole.folder / NAME
    everything, lines = without_time(ledger), ledger.read_bytes().splitlines(keepends=True)
    assert whole.complete
    assert len(lines) == 3 * 2 * 2
    ledger.write_bytes(b"".join(lines[:5]) + lines[5][:40])  # killed while it wrote the sixth
    again = flown(grid_file, "0-2")
    assert without_time(ledger) == everything
    assert ledger.read_bytes().startswith(b"".join(lines[:5]))
    assert again.episodes == again.wanted == 12
    more = flown(grid_file, "0-3")
    assert without_time(ledger)[:12] == everything
    assert more.episodes == 16


def test_an_interrupt_keeps_what_is_flown(grid_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def until_ctrl_c(scenario: Scenario, planner: str, seed: int) -> Row:
        if (seed, scenario.name) == (1, "other"):
            raise KeyboardInterrupt
        return flown_row(scenario, planner, seed)

    with monkeypatch.context() as patch:
        patch.setattr(campaign, "flown_row", until_ctrl_c)
        cut = flown(grid_file, "0-1")
    assert (cut.episodes, cut.wanted, cut.complete) == (6, 8, False)
    assert len(read_rows(cut.folder / NAME)) == 6
    assert flown(grid_file, "0-1").complete


def test_at_a_glance_every_scenario_is_told_with_its_runs(grid_file: Path) -> None:
    grid = load_grid(grid_file, (), (), None)
    told = {**entry("apf", 0.5, None, None, runs=7), "hit_obstacle_rate": 0.25, "hit_teammate_rate": 0.0}
    heading, fields, factor, decimals = GLANCES[3]
    assert heading == "Collided with an obstacle / with a teammate, %"
    text = glance(grid, [told], fields, factor, decimals)
    rows = [[part.strip() for part in row.split("|")[1:-1]] for row in text.splitlines()]
    assert rows[0] == ["scenario", "runs", "geo-apf", "apf"]
    assert rows[2:] == [["small", "7", "– / –", "25 / 0"], ["other", "0", "– / –", "– / –"]]


def test_scenarios_of_a_family_are_told_together_every_run_alike(grid_file: Path) -> None:
    both = GRID.replace('["small.toml"]', '["small.toml", "other.toml"]')
    grid_file.write_text(both.partition('[[families]]\nname = "Others"')[0])
    grid = load_grid(grid_file, (), (), None)
    rest = {"hit_teammate_rate": 0.0, "escape_rate": 0.0, "timeout_rate": 0.0, "min_clearance_m": None}
    small = {**entry("apf", 1.0, 5.0, 0.5, runs=30), **rest, "hit_obstacle_rate": 0.0, "min_separation_m": 2.5}
    other = {**entry("apf", 0.2, 5.0, 0.0, runs=10), **rest, "hit_obstacle_rate": 0.4, "min_separation_m": -0.001}
    heading, table = family_tables(grid, [small, {**other, "scenario": "other"}])
    assert heading == "### Lines"
    cells = [part.strip() for part in table.splitlines()[-1].split("|")[1:-1]]
    low, high = wilson_interval(32, 40)
    told = ["apf", "40", "80", f"{100 * low:.0f} to {100 * high:.0f}", "47", "10.0", "0.0", "0.0", "0.0", "–", "0.00"]
    assert cells == told


def test_seeds_come_one_after_another_over_everything(grid_file: Path) -> None:
    flown(grid_file, "0-1")
    rows = read_rows(grid_file.parent / "out" / NAME)
    assert [row["seed"] for row in rows] == [0] * 4 + [1] * 4


def test_only_what_is_named_is_flown_again(grid_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flown(grid_file, "0")
    monkeypatch.setattr(episode_row, "planner_stamp", lambda planner: f"newer {planner}")
    table = flown(grid_file, "0", ("apf",))
    assert {row["by"] for row in read_rows(table.folder / NAME) if row["planner"] == "apf"} == {"newer apf"}
    assert table.older.get("geo-apf", 0) == 0
    with pytest.raises(InputError, match="--again nobody: neither a planner nor a scenario"):
        flown(grid_file, "0", ("nobody",))


def test_a_changed_scenario_is_not_mixed_with_what_was_flown(grid_file: Path) -> None:
    flown(grid_file, "0")
    (grid_file.parent / "other.toml").write_text('extends = "small.toml"\n[layout]\ndiscs = 1\n')
    with pytest.raises(InputError, match="scenarios have changed since they were flown: other; add --again other"):
        flown(grid_file, "0-1")
    assert flown(grid_file, "0-1", ("other",)).complete


def test_a_planner_that_refuses_or_breaks_is_a_row_and_the_others_fly(grid_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(scenario: object, planner: str, seed: int) -> object:
        if planner == "apf":
            raise InputError("strategy 'apf': not here")
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(episode_row, "fly", fails)
    table = flown(grid_file, "0")
    by_planner = {entry["planner"]: entry for entry in table.figures}
    assert by_planner["apf"]["refused_rate"] == 1.0
    assert by_planner["geo-apf"]["broken_rate"] == 1.0
    assert "apf: strategy 'apf': not here" in table.markdown
    assert "ZeroDivisionError: by nothing" in table.markdown


def test_every_form_of_the_table_tells_the_same(grid_file: Path) -> None:
    table = flown(grid_file, "0-1")
    told = json.loads((table.folder / "table.json").read_text())["figures"]
    with (table.folder / "table.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [(line["scenario"], line["planner"]) for line in lines] == [
        ("small", "geo-apf"),
        ("small", "apf"),
        ("other", "geo-apf"),
        ("other", "apf"),
    ]
    for line, entry in zip(lines, told, strict=True):
        assert float(line["success_rate"]) == entry["success_rate"]
        outcomes = ("success_rate", "hit_obstacle_rate", "hit_teammate_rate", "escape_rate", "timeout_rate")
        assert sum(entry[name] for name in outcomes) == pytest.approx(1.0)
    page = (table.folder / "table.html").read_text()
    assert page.count("<tr><td>small</td><td>geo-apf</td>") == 1
    assert "http" not in page


def test_two_processes_do_not_fly_into_one_ledger(grid_file: Path) -> None:
    from flightapp.analysis.campaign.everything.ledger import opened

    flown(grid_file, "0")
    with opened(grid_file.parent / "out"), pytest.raises(InputError, match="another process flies this campaign"):
        flown(grid_file, "0-1")
    assert show_everything(load_grid(grid_file, (), (), None), grid_file.parent / "out").episodes == 4


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--planner", "nobody"], "--planner nobody: no such planner"),
        (["--scenario", "nowhere"], "--scenario nowhere: not in"),
        (["--seeds", "x"], "--seeds x"),
        (["--show"], "--show: no episode in"),
    ],
)
def test_bad_input_is_one_sentence(
    grid_file: Path, arguments: list[str], sentence: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(grid_file.parent)
    monkeypatch.setattr(sys, "argv", ["flightapp", "campaign", "all", str(grid_file), *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    said = capsys.readouterr()
    assert left.value.code == 2
    assert sentence in said.err
    assert len(said.err.strip().splitlines()) == 1
    assert not (grid_file.parent / "campaigns").exists()


def entry(planner: str, captured: float, time_s: float | None, encircled: float | None, runs: int = 100) -> dict[str, object]:
    low, high = wilson_interval(round(captured * runs), runs)
    return {
        "scenario": "small",
        "planner": planner,
        "runs": runs,
        "success_rate": captured,
        "success_ci95_low": low,
        "success_ci95_high": high,
        "capture_time_s": time_s,
        "encircled_at_capture_rate": encircled,
    }


def test_the_quickest_is_chosen_only_among_those_that_are_as_sure(grid_file: Path) -> None:
    grid = load_grid(grid_file, (), (), None)
    told = choices(
        grid,
        [
            entry("sure", 0.98, 20.0, 0.2),
            entry("as sure", 0.96, 15.0, 0.9),
            entry("quick but unsure", 0.60, 5.0, 1.0),
            entry("lucky", 1.0, 1.0, 1.0, runs=3),
            entry("never", 0.0, None, None),
        ],
    )
    assert told == [["small", "sure", "98", "as sure", "15.0", "as sure", "90"]]
    assert choices(grid, [entry("never", 0.0, None, None)])[0][1] == "none"


def test_the_repositorys_table_loads() -> None:
    grid = load_grid(Path(__file__).parents[3] / "missions" / "tables" / "everything.toml", (), (), None)
    assert len(grid.seeds) == 200
    assert {"ac2f", "oa-ecbvc", "hunting"} <= set(grid.planners)
    assert len(grid.scenarios) >= 25


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(100, 10**8), min_size=1, max_size=50), st.lists(st.integers(100, 10**8), max_size=50))
def test_quantiles_of_merged_histograms_are_those_of_all_decisions(one: list[int], other: list[int]) -> None:
    merged: dict[int, int] = {}
    for part in (one, other):
        for number, count in histogram(np.array(part, dtype=np.int64)).items():
            merged[int(number)] = merged.get(int(number), 0) + count
    for share in (0.5, 0.99):
        exact = np.quantile([*one, *other], share, method="inverted_cdf") * 1e-3
        assert quantile_us(merged, share) == pytest.approx(exact, rel=0.04)


def test_a_row_is_plain_json_and_the_same_again(grid_file: Path) -> None:
    scenario = load_grid(grid_file, (), (), None).scenarios[0]
    once, again = (flown_row(scenario, "apf", 3) for _ in range(2))
    json.dumps(once, allow_nan=False)
    for row in (once, again):
        row.pop("cpu_s"), row.pop("decision_histogram")
    assert once == again


CURVE = """
[[curves]]
name = "discs"
title = "A line"
scenarios = ["other", "small"]
against = "layout.discs"
label = "obstacles"
"""


def test_scenarios_that_differ_in_a_number_are_drawn_against_it(grid_file: Path) -> None:
    grid_file.write_text(GRID + CURVE)
    folder = flown(grid_file, "0").folder
    for name in ("discs-success.png", "discs-distances.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    grid = load_grid(grid_file, (), (), "0")
    found = lines(grid.curves[0], grid.scenarios, grid.planners, show_everything(grid, folder).figures)
    assert [x for x, _ in found["apf"]] == [0.0, 6.0], "in the order of the number, not of the file"


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        ('"other"', '"elsewhere"', "curves: discs: no scenario 'elsewhere' in families; it has small, other"),
        ("layout.discs", "evader.policy", "curves: discs: against = 'evader.policy': no number in scenario 'other'"),
        ("layout.discs", "nothing.at.all", "curves: discs: against = 'nothing.at.all': no number in scenario 'other'"),
    ],
)
def test_a_curve_over_what_is_not_there_is_refused(grid_file: Path, before: str, after: str, sentence: str) -> None:
    grid_file.write_text(GRID + CURVE.replace(before, after))
    with pytest.raises(InputError, match=sentence):
        load_grid(grid_file, (), (), "0")
