"""The demo, flown once as `make run` flies it; everything asserted comes from its own recordings.

Where `make run` has just flown it into a folder, FLIGHTAPP_FLOWN_DEMO names that folder and it is not flown again.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flightapp.config.mission import load_mission
from flightapp.recording.health import check_rates
from flightapp.recording.reader import read_recording
from tests.scenarios.simulation import DEMO, processes_of, simulation

VEHICLES = ("p1", "p2", "e1")
CPU_BUDGET_CORES = 0.6
"""Mean share of one core that a vehicle process may take in flight; measured 0.1-0.3."""
MEMORY_BUDGET_MB = 450.0
"""Resident memory of one vehicle process; measured 240-260."""


@dataclass(frozen=True, slots=True)
class Flown:
    """One demo, over."""

    run: Path
    summary: dict[str, Any]


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    given = os.environ.get("FLIGHTAPP_FLOWN_DEMO")
    run = Path(given) if given else fly_demo(tmp_path_factory.mktemp("demo"))
    assert processes_of(run) == [], "left behind"
    return Flown(run, json.loads((run / "summary.json").read_text()))


def fly_demo(folder: Path) -> Path:
    with simulation(folder) as demo:
        assert demo.process.wait(timeout=240) == 0, demo.said()
        assert demo.processes() == [], "left behind"
        assert demo.summary() == json.loads((demo.run / "summary.json").read_text())
        return demo.run


def test_the_evader_is_captured(flown: Flown) -> None:
    assert json.loads((flown.run / "run.json").read_text())["exit_status"] == dict.fromkeys(VEHICLES, 0)
    assert flown.summary["outcome"] == "captured"
    assert 0.0 < flown.summary["capture_time_s"] < 90.0


def test_nobody_touches_anything(flown: Flown) -> None:
    summary = flown.summary
    assert summary["min_obstacle_clearance_m"] > 0.0
    assert summary["min_separation_m"] > 1.0
    assert summary["boundary_distance_m"] > 0.0


def test_setpoints_flow_without_a_gap(flown: Flown) -> None:
    summary = flown.summary
    assert summary["setpoint_rate_hz"] >= 20.0
    assert summary["setpoint_gap_max_ms"] <= 200.0
    assert summary["dropped"] == 0


def test_every_channel_keeps_its_promised_rate(flown: Flown) -> None:
    mission = load_mission(DEMO)
    for name in VEHICLES:
        findings = check_rates(read_recording(flown.run / f"{name}.mcap"), mission.vehicle(name))
        assert findings, f"{name}: nothing was promised"
        assert [str(finding) for finding in findings if not finding.good] == []


def test_the_vehicle_process_stays_within_its_budget(flown: Flown) -> None:
    for name in VEHICLES:
        health = read_recording(flown.run / f"{name}.mcap").topic("/health")
        flying = health.column("cpu_fraction")[2:]  # the first samples still see the imports
        assert len(flying) > 10
        assert flying.mean() < CPU_BUDGET_CORES
        memory_mb = health.column("memory_mb")
        assert memory_mb.max() < MEMORY_BUDGET_MB
        assert memory_mb[-1] - memory_mb[len(memory_mb) // 3] < 20.0


def test_pursuers_knew_the_obstacles_only_through_their_cameras(flown: Flown) -> None:
    for name in ("p1", "p2"):
        obstacles = read_recording(flown.run / f"{name}.mcap").topic("/obstacles")
        frames = obstacles.column("frame_number")
        assert len(frames) > 100
        assert (np.diff(frames) > 0).all()
        assert max(len(message["discs"]) for message in obstacles.messages) > 0


def test_every_vehicle_is_back_home_on_the_ground(flown: Flown) -> None:
    mission = load_mission(DEMO)
    truth = read_recording(flown.run / "truth.mcap").topic("/truth").messages
    for vehicle in mission.vehicles:
        last = [message for message in truth if message["vehicle"] == vehicle.name][-1]
        assert last["on_ground"]
        assert not last["armed"]
        home = np.array([vehicle.start.north_m, vehicle.start.east_m])
        assert np.linalg.norm(np.array(last["position_ned_m"][:2]) - home) < 2.0


def test_report_and_inputs_lie_beside_the_recordings(flown: Flown) -> None:
    summary = flown.summary
    page = (flown.run / "report.html").read_text()
    assert "captured" in page
    assert (flown.run / "mission.toml").read_bytes() == DEMO.read_bytes()
    assert {entry["file"] for entry in summary["recordings"]} >= {f"{name}.mcap" for name in VEHICLES}
    assert all(entry["complete"] for entry in summary["recordings"])


def test_no_figure_of_the_issue_is_missing(flown: Flown) -> None:
    summary = flown.summary
    for name in ("capture_time_s", "path_length_m", "mean_jerk_m_s3", "min_obstacle_clearance_m", "min_separation_m"):
        assert isinstance(summary[name], float), name
    for stage in ("coarse", "fine"):
        assert set(summary["decision_latency_ms"][stage]) >= {"p50", "p99"}
    for name in ("perception_latency_ms", "frame_to_setpoint_ms"):
        assert summary[name]["p99"] >= summary[name]["p50"] > 0.0


def test_the_run_folder_holds_nothing_half_written(flown: Flown) -> None:
    assert [
        path for path in flown.run.iterdir() if path.suffix == ".tmp" or (path.stat().st_size == 0 and path.suffix != ".log")
    ] == []
