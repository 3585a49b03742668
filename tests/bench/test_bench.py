"""A short run of the bench: its structure and that every number means something, not how fast this machine is."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flightapp.bench import run_bench
from flightapp.bench.camera import NUMPY_ROW, PLAIN, RICH, pipeline_of
from flightapp.bench.depth_flight import FRAMES, DepthFlight, depth_flight, wood_between_walls
from flightapp.bench.measurement import REPETITIONS_MIN, Measurement, Percentiles, Work, measure
from flightapp.bench.memory import MemoryUse
from flightapp.bench.orca import orca_measurements
from flightapp.bench.perception_load import FRAMES_AN_HOUR, FrameMemory, FrameRate
from flightapp.bench.realsense_sdk import SDK_ROW, sdk_measurement
from flightapp.bench.run import NO_SDK
from flightapp.bench.simulator import Throughput
from flightapp.bench.table import print_bench
from flightapp.config.profile import load_profile
from flightapp.core.types import Limits

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / "missions/scenarios/a2-dense.toml"
STEPS = 800
ORCA = ("pyrvo, ORCA step alone, 40 neighbours", "pyrvo, ORCA from an observation, 40 discs")
CELLS = "oa-ecbvc, cells of one, 10 pursuers, 40 discs"
NAMES = [
    "planner, coarse step",
    "planner, fine step",
    "planner, fine evaluation, 441 samples",
    "planner in space, coarse step",
    *ORCA,
    CELLS,
    "oa-ecbvc, decision of one, 10 pursuers, 40 discs",
    "hunting, decision of one, 40 discs",
    "guidance, 400 tries of a search",
    "adaptive-apf, distances to 100 bodies and their force",
    "adaptive-apf, decision, 40 discs",
    PLAIN,
    RICH,
    NUMPY_ROW,
    SDK_ROW,
    "simulation, depth render",
    "supervisor, check with 40 discs",
    "recorder, six messages of a tick",
    "fleet state, encode and decode",
    "controller, one step",
    "space, distances to 100 bodies and their force",
    "path, RRT*-APF, 5000 iterations, 17 bodies",
]
COMPARED = {"planner, fine step", "planner, fine evaluation, 441 samples", RICH}
AIMS_MS = {
    "planner, coarse step": 0.05,
    "planner, fine step": 0.25,
    "planner in space, coarse step": 0.5,
    CELLS: 0.3,
    "hunting, decision of one, 40 discs": 2.0,
    "guidance, 400 tries of a search": 10.0,
    "adaptive-apf, distances to 100 bodies and their force": 0.02,
    PLAIN: 2.0,
    RICH: 2.0,
    "recorder, six messages of a tick": 0.2,
    "controller, one step": 0.02,
    "space, distances to 100 bodies and their force": 0.02,
    "path, RRT*-APF, 5000 iterations, 17 bodies": 100.0,
}


@pytest.fixture(scope="module")
def result() -> dict[str, Any]:
    return run_bench(ROOT / "missions/demo_two_pursuers.toml", ROOT / "profiles/sim.toml", SCENARIO, 0.15, STEPS)


@pytest.fixture(scope="module")
def flight() -> DepthFlight:
    return depth_flight(wood_between_walls(), load_profile(ROOT / "profiles/sim.toml").camera, 0.0, 0.0)


@pytest.fixture(scope="module")
def without_pyrvo(result: dict[str, Any]) -> dict[str, Any]:
    """The same result as it comes out where pyrvo is not installed."""
    rows = [one for one in result["measurements"] if one["name"] not in ORCA]
    rows = [{**one, "orca_ratio": None} for one in rows]
    return {**result, "measurements": rows, "not_measured": [{"name": ORCA[1], "why": "pyrvo is not installed"}]}


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
    assert {one["name"] for one in result["measurements"] if one["faster_by"] is not None} == COMPARED
    assert {one["name"] for one in result["measurements"] if one["orca_ratio"] is not None} == {NAMES[0], NAMES[1]}
    assert {one["name"] for one in result["measurements"] if one["sdk_ratio"] is not None} == {RICH}
    kinds = ("faster_by", "orca_ratio", "sdk_ratio")
    ratios = [one[kind] for one in result["measurements"] for kind in kinds if one[kind] is not None]
    assert all(math.isfinite(ratio) and ratio > 0.0 for ratio in ratios)


def test_orcas_decision_takes_longer_than_its_step_alone(result: dict[str, Any]) -> None:
    step, decision = (one["cpu_ms"]["p50"] for one in result["measurements"] if one["name"] in ORCA)
    assert step < decision


def test_without_pyrvo_its_row_says_so(
    without_pyrvo: dict[str, Any], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyrvo", None)
    assert orca_measurements(Limits(5.0, 5.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45), 0.1) is None
    print_bench(without_pyrvo)
    text = capsys.readouterr().out
    assert "not measured" in text
    assert "pyrvo is not installed" in text


def test_without_the_realsense_sdk_its_row_says_so(
    result: dict[str, Any], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    assert sdk_measurement(DepthFlight(()), 0.1) is None
    rows = [{**one, "sdk_ratio": None} for one in result["measurements"] if one["name"] not in (SDK_ROW, *ORCA)]
    missing = [{"name": SDK_ROW, "why": NO_SDK}, {"name": ORCA[1], "why": "pyrvo is not installed"}]
    print_bench({**result, "measurements": rows, "not_measured": missing})
    text = capsys.readouterr().out
    assert text.count("not measured") == 2
    assert "pyrealsense2 cannot be imported" in text
    assert "pyrvo is not installed" in text


def test_perception_is_compared_on_the_same_frames(result: dict[str, Any]) -> None:
    p50 = {one["name"]: one["cpu_ms"]["p50"] for one in result["measurements"]}
    rich = next(one for one in result["measurements"] if one["name"] == RICH)
    assert rich["sdk_ratio"] == pytest.approx(p50[SDK_ROW] / p50[RICH])
    assert rich["faster_by"] == pytest.approx(p50[NUMPY_ROW] / p50[RICH])


def test_a_long_flight_of_perception_is_measured(result: dict[str, Any]) -> None:
    rate, memory = result["frame_rate"], result["frame_memory"]
    assert rate["frames"] == memory["frames"] == STEPS // 4
    assert rate["aim"] == 90.0
    assert rate["frames_per_cpu_s"] > 0.0
    assert rate["frames_per_s"] > 0.0
    assert memory["before_mib"] > 10.0
    assert memory["hour_mib"] == pytest.approx(memory["slope_bytes_per_frame"] * FRAMES_AN_HOUR / 2**20)


@pytest.mark.parametrize(
    ("wall", "cpu", "verdict"), [(91.0, 92.0, "met"), (60.0, 92.0, "met in CPU time"), (60.0, 80.0, "missed")]
)
def test_the_verdict_on_the_frame_rate(wall: float, cpu: float, verdict: str) -> None:
    assert FrameRate(100, wall, cpu).verdict == verdict


@pytest.mark.parametrize(("after_mib", "verdict"), [(100.9, "flat"), (101.1, "grows")])
def test_perception_that_takes_ever_more_memory_is_called_so(after_mib: float, verdict: str) -> None:
    assert FrameMemory(1000, 90.0, 100.0, after_mib, 0.0, 0.0).verdict == verdict


def test_the_measured_flight_is_one_way_and_the_same_way_back(flight: DepthFlight) -> None:
    norths = [flight.shot(k)[1].position_ned_m[0] for k in range(2 * FRAMES + 1)]
    steps = np.diff(norths)
    assert np.abs(steps).max() == pytest.approx(0.1)  # 3 m/s at 30 Hz: never a jump
    assert norths[0] == norths[2 * FRAMES - 1] == norths[2 * FRAMES]
    for k, (there, back) in enumerate(((0, 2 * FRAMES - 1), (10, 2 * FRAMES - 11))):
        np.testing.assert_array_equal(flight.shot(there)[0].depth, flight.shot(back)[0].depth, err_msg=str(k))
    times = [flight.shot(k)[0].t_s for k in range(2 * FRAMES)]
    np.testing.assert_allclose(np.diff(times), 1 / 30)


def test_the_wood_is_rich_and_every_frame_of_it_is_used(flight: DepthFlight) -> None:
    pipeline = pipeline_of(load_profile(ROOT / "profiles/sim.toml"), 0.0)
    seen = [pipeline.process(*flight.shot(k)) for k in range(FRAMES)]
    assert not [found.events for found in seen if found.events]
    assert min(len(found.discs) for found in seen) >= 20


def test_the_simulator_and_memory_are_measured(result: dict[str, Any]) -> None:
    simulator, memory = result["simulator"], result["memory"]
    assert (simulator["scenario"], simulator["planner"], simulator["pursuers"]) == ("a2-dense", "ac2f", 2)
    assert simulator["simulated_s"] > 0.0
    assert simulator["simulated_s_per_s"] > 0.0
    assert simulator["aim"] == 500.0
    assert memory["steps"] == STEPS == sum(memory["modes"].values())
    assert set(memory["modes"]) >= {"coarse", "fine"}
    assert memory["before_mib"] > 10.0
    assert math.isfinite(memory["slope_bytes_per_step"])


@pytest.mark.parametrize(("after_mib", "verdict"), [(100.9, "flat"), (101.1, "grows"), (90.0, "flat")])
def test_memory_that_grows_is_called_so(after_mib: float, verdict: str) -> None:
    assert MemoryUse(1000, 90.0, 100.0, after_mib, 0.0, {}).verdict == verdict


@pytest.mark.parametrize(
    ("wall", "cpu", "verdict"), [(501.0, 510.0, "met"), (300.0, 510.0, "met in CPU time"), (300.0, 400.0, "missed")]
)
def test_the_simulators_verdict(wall: float, cpu: float, verdict: str) -> None:
    assert Throughput("x", "ac2f", 2, 1, 10.0, wall, cpu, 500.0).verdict == verdict


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
