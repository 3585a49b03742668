"""A short run of the bench: its structure and that every number means something, not how fast this machine is."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from flightapp.bench import run_bench
from flightapp.bench.measurement import REPETITIONS_MIN, Measurement, Percentiles, Work, measure
from flightapp.bench.table import print_bench

ROOT = Path(__file__).parents[2]
NAMES = [
    "planner, coarse step",
    "planner, fine step",
    "planner, roll-out kernel",
    "perception, frame to discs",
    "simulation, depth render",
    "supervisor, check with 40 discs",
    "recorder, five messages of a tick",
    "fleet state, encode and decode",
]
AIMS_MS = {"planner, coarse step": 0.2, "planner, fine step": 1.0, "perception, frame to discs": 3.0}


@pytest.fixture(scope="module")
def result() -> dict[str, Any]:
    return run_bench(ROOT / "missions/demo_two_pursuers.toml", ROOT / "profiles/sim.toml", 0.5)


def test_everything_is_measured_in_wall_and_cpu_time(result: dict[str, Any]) -> None:
    assert [one["name"] for one in result["measurements"]] == NAMES
    for one in result["measurements"]:
        assert one["repetitions"] >= REPETITIONS_MIN
        for kind in ("wall_ms", "cpu_ms"):
            p50, p99, largest = (one[kind][name] for name in ("p50", "p99", "max"))
            assert all(math.isfinite(value) and value > 0.0 for value in (p50, p99, largest))
            assert p50 <= p99 <= largest
        assert one["aim_ms"] == AIMS_MS.get(one["name"])
        assert bool(one["verdict"]) == (one["name"] in AIMS_MS)
    ratios = [one["faster_by"] for one in result["measurements"] if one["faster_by"] is not None]
    assert len(ratios) == 2
    assert all(math.isfinite(ratio) and ratio > 0.0 for ratio in ratios)


def test_the_machine_is_named_and_all_of_it_is_json(result: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    json.dumps(result, allow_nan=False)
    assert result["machine"]["cpu"]
    assert len(result["machine"]["load_average"]) == 3
    print_bench(result)
    text = capsys.readouterr().out
    assert result["machine"]["cpu"] in text
    assert all(name in text for name in NAMES)


@pytest.mark.parametrize(
    ("wall_p99", "cpu_p99", "verdict"), [(0.5, 0.5, "met"), (2.0, 0.5, "met in CPU time"), (2.0, 2.0, "missed")]
)
def test_the_verdict_tells_a_busy_machine_from_slow_code(wall_p99: float, cpu_p99: float, verdict: str) -> None:
    found = Measurement("x", 100, Percentiles(0.1, wall_p99, 3.0), Percentiles(0.1, cpu_p99, 3.0), 1.0)
    assert found.verdict == verdict


def test_preparation_and_warm_up_are_not_measured() -> None:
    prepared: list[int] = []
    done: list[int] = []
    found = measure(Work("x", lambda k: prepared.append(k) or k, done.append, warm_up=3), 0.0)
    assert done == prepared == list(range(3 + REPETITIONS_MIN))
    assert found.repetitions == REPETITIONS_MIN
