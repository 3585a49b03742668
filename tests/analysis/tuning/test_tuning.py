"""Tuning finds the optimum of a known cost, goes on after an interruption as if there had been none, and writes its file."""

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.analysis.campaign import runner
from flightapp.analysis.campaign.workers import Workers
from flightapp.analysis.tuning.objective import cost, mean_cost
from flightapp.analysis.tuning.optimiser import first_points
from flightapp.analysis.tuning.tune import Problem
from flightapp.analysis.tuning.tuning_run import Tuned, run_tuning
from flightapp.analysis.tuning.weights import X_MAX, X_MIN, weights_of
from flightapp.core.errors import InputError
from flightapp.sim.batch.result import Outcome, RunResult
from flightapp.sim.batch.scenario import Scenario
from tests.analysis.campaign.small import small_scenario

SEEDS = (10000, 10001)
BEST = (0.6392, 0.0490)
"""alpha and beta."""


def result(outcome: Outcome = "captured", time_s: float = 10.0) -> RunResult:
    return RunResult(
        scenario="small",
        planner="ac2f",
        seed=0,
        outcome=outcome,
        collided_with="obstacle" if outcome == "collided" else "",
        duration_s=time_s,
        capture_time_s=time_s if outcome == "captured" else None,
        path_length_m=50.0,
        mean_jerk_m_s3=8.0,
        boundary_distance_m=6.0,
        min_clearance_m=0.5,
        min_separation_m=2.0,
        decision_ns=np.array([1000], dtype=np.int64),
        mode_share={"coarse": 1.0},
        shortest_path_m=None,
        sim_wall_ns=1000,
    )


class Bowl:
    """Stands in for a flight: the time to capture grows with the distance from BEST. Ctrl-C at one of the calls."""

    def __init__(self, interrupted_at: int | None = None) -> None:
        self.calls, self.interrupted_at = 0, interrupted_at

    def __call__(self, scenario: Scenario, planner: str, seed: int, parameters: Mapping[str, float]) -> RunResult:
        self.calls += 1
        if self.calls == self.interrupted_at:
            raise KeyboardInterrupt
        away = (parameters["weight_heading"] - BEST[0]) ** 2 + (parameters["weight_clearance"] - BEST[1]) ** 2
        return result(time_s=10.0 + 60.0 * away + seed % 2)


def problem(folder: Path, seed: int = 0) -> Problem:
    return Problem(small_scenario(folder), "ac2f", SEEDS, {"horizon_s": 0.9}, 6, seed)


def tuned(folder: Path, bowl: Bowl, monkeypatch: pytest.MonkeyPatch, *, again: bool = False, seed: int = 0) -> Tuned:
    monkeypatch.setattr(runner, "fly", bowl)
    return run_tuning(problem(folder, seed), 2, Workers(1), folder / "w.toml", "flightapp tune small.toml", again=again)


def test_an_interrupted_optimisation_goes_on_as_if_it_had_not_been(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    whole.mkdir()
    parts.mkdir()
    uninterrupted = tuned(whole, Bowl(), monkeypatch)
    # in the middle of a batch of the second suggestion
    stopped = tuned(parts, Bowl(interrupted_at=2 * 7 + 2), monkeypatch)
    assert not stopped.complete
    assert not (parts / "w.toml").exists()
    with pytest.raises(InputError, match="exists already; go on with --resume"):
        tuned(parts, Bowl(), monkeypatch)
    with pytest.raises(InputError, match="another seed"):
        tuned(parts, Bowl(), monkeypatch, again=True, seed=1)
    resumed = tuned(parts, Bowl(), monkeypatch, again=True)
    assert resumed.complete
    assert (parts / "w.jsonl").read_bytes() == (whole / "w.jsonl").read_bytes()
    assert (parts / "w.toml").read_bytes() == (whole / "w.toml").read_bytes()
    assert uninterrupted.summary["j"] == resumed.summary["j"]
    costs = [json.loads(line)["j"] for line in (whole / "w.jsonl").read_text().splitlines()[1:]]
    assert min(costs) == uninterrupted.summary["j"]
    assert min(costs[6:]) < min(costs[:6]), "suggestions from the Gaussian process beat the Latin hypercube on a smooth bowl"
    written = tomllib.loads((whole / "w.toml").read_text())
    assert written["horizon_s"] == 0.9
    weights = [written[f"weight_{name}"] for name in ("heading", "clearance", "velocity")]
    assert sum(weights) == pytest.approx(1.0)
    assert (whole / "w.png").stat().st_size > 10_000


def test_the_objective_is_that_of_the_source() -> None:
    captured = 10.0 + 0.2 * 50.0 - 0.5 * 6.0
    assert cost(result()) == pytest.approx(captured)
    assert cost(result("collided")) == pytest.approx(captured + 105.0)
    assert cost(result("escaped")) == cost(result("timed_out")) == pytest.approx(captured + 100.0)
    assert mean_cost([result(), result("timed_out")]) == pytest.approx(captured + 50.0)


@given(st.floats(X_MIN, X_MAX), st.floats(X_MIN, X_MAX))
def test_every_point_of_the_square_gives_positive_weights_that_sum_to_one(x1: float, x2: float) -> None:
    weights = weights_of(x1, x2)
    assert min(weights.alpha, weights.beta, weights.gamma) > 0.0
    assert weights.alpha + weights.beta + weights.gamma == pytest.approx(1.0, abs=1e-12)


def test_the_first_points_are_a_latin_hypercube() -> None:
    for axis in (0, 1):
        cells = [int((point[axis] - X_MIN) / (X_MAX - X_MIN) * 20) for point in first_points(20, 3)]
        assert sorted(cells) == list(range(20))
