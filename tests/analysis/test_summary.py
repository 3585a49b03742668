"""The summary of made-up runs against what was made up."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from flightapp.analysis import report, write_picture, write_report, write_summary
from flightapp.analysis.findings import Finding, Severity, as_json, reaches
from flightapp.analysis.outcome import fold_outcome
from flightapp.analysis.run import load_run
from flightapp.analysis.summary import Summary
from flightapp.analysis.verdict import one_line, verdict_of
from flightapp.cli import app
from flightapp.core.errors import InputError
from flightapp.recording import messages
from flightapp.recording.health import check_rates
from flightapp.recording.reader import read_recording
from flightapp.recording.recorder import Recorder
from tests.analysis.synthetic_run import CAPTURED_S, LAND_S, MISSION, MOTIONS, PURSUE_S, T0_S, TAKEOFF_S, write_run


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("runs") / "run")


@pytest.fixture(scope="module")
def summary(run: Path) -> Summary:
    path = write_summary(run)
    assert path == run / "summary.json"
    return dict(json.loads(path.read_text()))


def sampled(name: str, start_s: float, end_s: float) -> np.ndarray:
    return np.array([MOTIONS[name].position(t_s) for t_s in np.arange(start_s, end_s, 0.01)])


def nearest(first: str, second: str, start_s: float, end_s: float) -> float:
    gap = sampled(first, start_s, end_s) - sampled(second, start_s, end_s)
    return float(np.linalg.norm(gap, axis=1).min())


def test_mission_outcome_and_times(summary: Summary) -> None:
    assert summary["mission"] == "demo_two_pursuers"
    assert summary["seed"] == 7
    assert summary["outcome"] == "captured"
    assert summary["capture_time_s"] == pytest.approx(CAPTURED_S - PURSUE_S, abs=0.05)
    assert [one["complete"] for one in summary["recordings"]] == [True] * 4
    assert summary["dropped"] == 0
    assert summary["errors"] == []
    assert summary["events"] == {"info": 6, "warning": 1, "error": 0}


def test_geometry(summary: Summary) -> None:
    assert summary["min_separation_m"] == pytest.approx(nearest("p1", "p2", TAKEOFF_S, LAND_S), abs=0.01)
    expected = min(nearest(name, "e1", PURSUE_S, CAPTURED_S) for name in ("p1", "p2"))
    assert summary["min_target_distance_m"] == pytest.approx(expected, abs=0.01)
    lengths = {}
    for name in MOTIONS:
        steps = np.diff(sampled(name, PURSUE_S, CAPTURED_S), axis=0)
        lengths[name] = np.linalg.norm(steps, axis=1).sum()
        assert summary["vehicles"][name]["path_length_m"] == pytest.approx(lengths[name], rel=0.01)
    assert summary["path_length_m"] == pytest.approx((lengths["p1"] + lengths["p2"]) / 2, rel=0.01)
    assert summary["boundary_distance_m"] == pytest.approx(20.0)
    assert summary["boundary_distance_at_capture_m"] == pytest.approx(20.0)
    assert summary["evader_track_source"] == "truth"
    tree = np.array([16.0, 5.0])
    gap = np.linalg.norm(sampled("p2", TAKEOFF_S, LAND_S)[:, :2] - tree, axis=1).min() - 0.8 - 0.35
    assert summary["vehicles"]["p2"]["min_obstacle_clearance_m"] == pytest.approx(gap, abs=0.012)
    assert summary["min_obstacle_clearance_m"] == summary["vehicles"]["p2"]["min_obstacle_clearance_m"]


def test_timing(summary: Summary) -> None:
    assert summary["frame_to_setpoint_ms"] == {"p50": pytest.approx(31.0, abs=0.01), "p99": pytest.approx(31.0, abs=0.01)}
    assert summary["setpoint_rate_hz"] == pytest.approx(30.0, abs=0.1)
    assert summary["setpoint_gap_max_ms"] == pytest.approx(1000 / 30, abs=0.1)
    assert summary["setpoint_gap_p99_ms"] == pytest.approx(1000 / 30, abs=0.1)
    assert summary["decision_latency_ms"]["coarse"]["p50"] == pytest.approx(0.8, abs=0.1)
    assert summary["decision_latency_ms"]["fine"]["p50"] == pytest.approx(3.1, abs=0.1)
    assert summary["vehicles"]["e1"]["perception_latency_ms"] == {"p50": None, "p99": None}
    assert sum(summary["vehicles"]["p1"]["modes"].values()) == pytest.approx(1.0)
    assert 0.22 < summary["cpu_fraction"]["mean"] < 0.25
    assert summary["memory_mb"]["max"] == pytest.approx(145.0, abs=0.1)


def test_the_recorded_rates_are_healthy(run: Path) -> None:
    assert all(finding.good for finding in check_rates(read_recording(run / "p1.mcap")))


def test_verdict_of_a_good_run(summary: Summary) -> None:
    verdict = verdict_of(summary)
    assert (verdict.level, verdict.headline) == ("good", "The evader was captured after 33.0 s")


def test_what_broke_a_limit_is_said(summary: Summary) -> None:
    broken = as_json(Finding("separation", Severity.FAILURE, "separation lost", "Too close.", vehicle="p1"))
    close = as_json(Finding("battery", Severity.WARNING, "reserve used", "15 % was left.", vehicle="p2"))
    verdict = verdict_of(summary | {"findings": [broken, close]})
    assert (verdict.level, verdict.reasons) == ("bad", ("p1: separation lost", "p2: reserve used"))
    assert one_line(summary | {"findings": [broken, close]}).endswith("; 1 failure, 1 warning")
    assert verdict_of(summary | {"findings": [close]}).level == "attention"
    margin = verdict_of(summary | {"min_obstacle_clearance_m": 0.2})
    assert (margin.level, len(margin.reasons)) == ("attention", 1)
    assert verdict_of(summary | {"outcome": "timeout", "capture_time_s": None}).level == "attention"
    error = {"t_s": T0_S, "vehicle": "p1", "name": "fault", "text": "no depth frames"}
    fault = verdict_of(summary | {"outcome": "fault", "errors": [error]})
    assert (fault.level, fault.headline, fault.reasons) == ("bad", "The mission ended with a fault", ("p1: no depth frames",))
    assert verdict_of(summary | {"outcome": None}).headline == "No outcome was recorded"


def test_the_report_is_one_file_that_needs_no_network(run: Path) -> None:
    _, page = report([run])
    text = page.read_text()
    assert "<script src" not in text
    assert "<link" not in text[: text.index("<script>")]
    assert "Plotly.newPlot(place" in text
    assert "The evader was captured after 33.0 s" in text
    assert page == write_report(run)
    assert not list(run.glob(".*.tmp"))


def test_recorded_text_cannot_break_the_page(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        text = "</script><script>alert(1)</script>"
        recorder.log("/event", messages.Event(T0_S, text, text, text), T0_S)
        recorder.log("/phase", messages.Phase(T0_S, "pursue", text, None), T0_S)
        for step in range(10):
            now_s = T0_S + step
            recorder.log("/own", messages.OwnState(now_s, [step, 0.0, 0.0], [1.0, 0.0, 0.0], 0, 0, 0, 0), now_s)
            recorder.log("/decision", messages.DecisionRecord(now_s, [0, 0, 0], 0.0, text, None, "", 0.0, {}), now_s)
    assert "<script>alert" not in write_report(tmp_path).read_text()


def test_the_picture_is_a_picture(run: Path) -> None:
    image = cv2.imread(str(write_picture(run)))
    assert image is not None
    assert image.shape[0] > 900
    assert image.shape[1] > 900


def test_a_run_that_was_cut_off_is_reported_with_what_there_is(run: Path, tmp_path: Path) -> None:
    for path in run.glob("*.mcap"):
        content = path.read_bytes()
        (tmp_path / path.name).write_bytes(content[: len(content) // 2] if path.stem == "p1" else content)
    (tmp_path / "junk.mcap").write_bytes(b"junk")
    summary, page = report([tmp_path])  # mission and profile come from inside the recordings
    assert page.is_file()
    assert summary["outcome"] == "captured"
    states = {one["file"]: one["complete"] for one in summary["recordings"]}
    assert states == {"e1.mcap": True, "p1.mcap": False, "p2.mcap": True, "truth.mcap": True, "junk.mcap": False}
    assert summary["vehicles"]["p1"]["outcome"] is None
    assert summary["min_separation_m"] is not None
    verdict = verdict_of(summary)
    assert verdict.level == "attention"
    assert "incomplete recordings: p1.mcap, junk.mcap" in verdict.reasons


def test_without_truth_own_states_are_used(run: Path, tmp_path: Path) -> None:
    for name in ("p1.mcap", "p2.mcap"):
        (tmp_path / name).write_bytes((run / name).read_bytes())
    summary, page = report([tmp_path / "p1.mcap", tmp_path / "p2.mcap"])
    assert page == tmp_path / "p1-report.html"
    assert summary["vehicles"]["p1"]["track_source"] == "own"
    assert summary["evader_track_source"] == "estimate"
    assert summary["min_separation_m"] == pytest.approx(nearest("p1", "p2", TAKEOFF_S, LAND_S), abs=0.15)


def test_what_was_not_recorded_is_null(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/battery", messages.Battery(T0_S, 15.0, None), T0_S)
    summary, _ = report([tmp_path])
    for name in (
        "mission",
        "seed",
        "outcome",
        "capture_time_s",
        "path_length_m",
        "mean_jerk_m_s3",
        "min_obstacle_clearance_m",
        "min_separation_m",
        "min_target_distance_m",
        "setpoint_rate_hz",
        "setpoint_gap_max_ms",
    ):
        assert summary[name] is None, name
    assert summary["decision_latency_ms"]["fine"] == {"p50": None, "p99": None}
    assert summary["cpu_fraction"] == {"mean": None, "max": None}


def test_nothing_to_read_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no recording"):
        report([tmp_path])
    with pytest.raises(InputError, match="name a run folder"):
        report([])
    with pytest.raises(InputError, match="no such file"):
        report([tmp_path / "p1.mcap"])
    (tmp_path / "p1.mcap").write_bytes(b"junk")
    with pytest.raises(InputError, match="not a recording"):
        report([tmp_path])


@pytest.mark.parametrize(
    ("outcomes", "folded"),
    [
        ({"p1": "captured", "p2": "fault", "e1": None}, "fault"),
        ({"p1": "aborted", "p2": "captured", "e1": "escaped"}, "captured"),
        ({"p1": "timeout", "p2": "escaped", "e1": "captured"}, "escaped"),
        ({"p1": "aborted", "p2": "timeout", "e1": None}, "timeout"),
        ({"p1": "aborted", "p2": None, "e1": None}, "aborted"),
        ({"p1": None, "p2": None, "e1": None}, None),
    ],
)
def test_one_outcome_out_of_many(tmp_path: Path, outcomes: dict[str, str | None], folded: str | None) -> None:
    (tmp_path / "mission.toml").write_bytes(MISSION.read_bytes())
    for name, outcome in outcomes.items():
        with Recorder(tmp_path / f"{name}.mcap") as recorder:
            recorder.log("/phase", messages.Phase(T0_S, "pursue", "", None), T0_S)
            recorder.log("/phase", messages.Phase(T0_S + 5.0, "return", "", outcome), T0_S + 5.0)
    assert fold_outcome(load_run([tmp_path])) == folded


def test_what_was_found_decides_the_exit_status_only_when_asked(run: Path, summary: Summary) -> None:
    warned = summary | {"findings": [as_json(Finding("battery", Severity.WARNING, "reserve used", "15 % was left."))]}
    assert [reaches(warned, least) for least in (None, "failure", "warning")] == [False, False, True]
    beside = summary | {"autopilot_logs": [{"findings": [as_json(Finding("gps", Severity.FAILURE, "no fix", "None."))]}, {}]}
    assert reaches(beside, "failure")
    told = CliRunner().invoke(app, ["report", str(run), "--fail-on", "failure"])
    assert told.exit_code == 0
    assert "verdict: The evader was captured after 33.0 s; no failures or warnings" in told.output
