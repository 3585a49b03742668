"""A whole small campaign: the same whatever the number of workers, told without gaps, kept when it is cut short."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from flightapp.analysis.campaign.campaign import Campaign, Finished, run_campaign
from flightapp.analysis.campaign.drawing import Drawing
from flightapp.analysis.campaign.parquet import SCHEMA, TIMING_COLUMNS
from flightapp.analysis.campaign.question import planners_and_seeds
from flightapp.analysis.campaign.runner import fly_jobs, paired_jobs
from flightapp.analysis.campaign.summary import planner_details, summarise
from flightapp.analysis.campaign.table import markdown
from flightapp.analysis.campaign.workers import Workers
from flightapp.analysis.run import load_run
from flightapp.analysis.summary import summarise as summarise_run
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario, load_scenario
from tests.analysis.campaign.small import small_file, small_scenario

SEEDS = tuple(range(8))
KEYS = {
    "planner",
    "runs",
    "success_rate",
    "success_ci95",
    "p_value",
    "collision_rate",
    "escape_rate",
    "timeout_rate",
    "capture_time_s",
    "path_length_m",
    "mean_jerk_m_s3",
    "boundary_distance_m",
    "min_clearance_m",
    "min_separation_m",
    "travel_m",
    "turning_rad",
    "encircled_at_capture_rate",
    "encircled_share",
    "encircled_first_s",
    "decision_ms",
    "simulated_s_per_s",
}


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    return small_scenario(tmp_path_factory.mktemp("scenario"))


@pytest.fixture(scope="module")
def finished(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    campaign = Campaign(scenario, ("ac2f",), SEEDS, {}, Drawing((3,), 1, (3, 4)))
    return run_campaign(campaign, Workers(1), tmp_path_factory.mktemp("campaign") / "one")


def test_two_workers_fly_the_same_as_one(scenario: Scenario, finished: Finished, tmp_path: Path) -> None:
    two = run_campaign(Campaign(scenario, ("ac2f",), SEEDS, {}, Drawing((), 0)), Workers(2), tmp_path / "two")
    tables = [pq.read_table(folder / "runs.parquet") for folder in (finished.folder, two.folder)]
    assert tables[0].schema.equals(SCHEMA)
    assert tables[0].column("seed").to_pylist() == list(SEEDS)
    assert tables[0].drop_columns(list(TIMING_COLUMNS)).equals(tables[1].drop_columns(list(TIMING_COLUMNS)))


def test_machines_get_exactly_these_keys_and_only_numbers(finished: Finished) -> None:
    assert set(finished.summary) == {"scenario", "seeds", "planners"}
    (figures,) = finished.summary["planners"]
    assert set(figures) == KEYS
    assert set(figures["decision_ms"]) == {"p50", "p99"}
    json.dumps(finished.summary, allow_nan=False)
    shares = [figures[name] for name in ("success_rate", "collision_rate", "escape_rate", "timeout_rate")]
    assert sum(shares) == pytest.approx(1.0)
    assert figures["success_rate"] > 0.5
    assert figures["p_value"] is None


def test_pictures_of_the_seeds_asked_for_are_there(finished: Finished) -> None:
    failed = json.loads((finished.folder / "summary.json").read_text())["planners"][0]["failed_seeds"]
    names = {
        "paths-3.png",
        "distance-3.png",
        "modes-ac2f-3.png",
        "convergence.png",
        *(f"failed-ac2f-{seed}.png" for seed in failed[:1]),
    }
    assert {path.name for path in finished.folder.glob("*.png")} == names
    assert "| ac2f" in (finished.folder / "table.md").read_text()


def test_a_run_alone_is_recorded_as_it_was_flown(scenario: Scenario, finished: Finished, tmp_path: Path) -> None:
    seed = next(
        row["seed"] for row in pq.read_table(finished.folder / "runs.parquet").to_pylist() if row["outcome"] == "captured"
    )
    campaign = Campaign(scenario, ("ac2f",), (seed,), {}, Drawing((), 0), record=True)
    alone = run_campaign(campaign, Workers(1), tmp_path / "alone")
    (row,) = pq.read_table(alone.folder / "runs.parquet").to_pylist()
    told = summarise_run(load_run([alone.folder / "recordings" / f"ac2f-{seed}"]))
    assert told["outcome"] == "captured"
    assert told["seed"] == seed
    assert told["capture_time_s"] == pytest.approx(row["capture_time_s"], abs=1e-6)
    assert told["path_length_m"] == pytest.approx(row["path_length_m"], rel=0.01)
    assert told["min_target_distance_m"] == pytest.approx(scenario.capture.radius_m, abs=0.05)
    assert [finding for finding in told["findings"] if finding["severity"] == "failure"] == []


def test_what_the_command_line_leaves_out_the_scenario_says(tmp_path: Path) -> None:
    path = small_file(tmp_path)
    asked = load_scenario(path, {"campaign.planners": "['geo-apf', 'ac2f']", "campaign.seeds": "'3,7'"})
    assert planners_and_seeds(path, asked, [], None) == (("geo-apf", "ac2f"), (3, 7))
    assert planners_and_seeds(path, asked, ["apf"], "0-1") == (("apf",), (0, 1))


def test_ctrl_c_keeps_what_is_finished(scenario: Scenario) -> None:
    seen: list[RunResult] = []

    def note(results: Sequence[RunResult]) -> None:
        seen.extend(results)
        if len(seen) == 3:
            raise KeyboardInterrupt

    flown = fly_jobs(scenario, paired_jobs(["ac2f"], SEEDS), Workers(1), note=note)
    assert not flown.complete
    assert [result.seed for result in flown.results] == [0, 1, 2]


def test_without_any_success_figures_are_null_and_not_nan(scenario: Scenario) -> None:
    hopeless = scenario.model_copy(update={"time_limit_s": 0.2})
    flown = fly_jobs(hopeless, paired_jobs(["ac2f"], [0]), Workers(1))
    (figures,) = summarise(hopeless, "0", ["ac2f"], flown.results)["planners"]
    assert figures["timeout_rate"] == 1.0
    assert figures["capture_time_s"] is None
    assert figures["min_clearance_m"] is None
    assert math.isfinite(figures["simulated_s_per_s"])


def test_what_a_strategy_flags_is_told_as_a_share_of_its_decisions(scenario: Scenario) -> None:
    results = fly_jobs(scenario, paired_jobs(("ac2f", "greedy"), SEEDS[:2]), Workers(1)).results
    by_planner = {planner: [result for result in results if result.planner == planner] for planner in ("ac2f", "greedy")}
    details = {planner: planner_details(runs) for planner, runs in by_planner.items()}
    assert details["ac2f"]["flag_share"] == {}
    assert details["greedy"]["flag_share"]["cannot encircle"] == 1.0, "two never do"
    told = markdown(summarise(scenario, "0-1", ("ac2f", "greedy"), results), details)
    assert any(line.startswith("| greedy") and "cannot encircle 100.0" in line for line in told.splitlines())
