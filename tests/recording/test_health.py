"""Recorded rates against the channel table."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.config.mission import load_mission
from flightapp.recording import messages
from flightapp.recording.health import check_rates
from flightapp.recording.reader import Recording, read_recording
from flightapp.recording.recorder import Recorder
from tests.recording.samples import T0_S, log_steps, own

MISSION = load_mission(Path(__file__).resolve().parents[2] / "missions" / "demo_two_pursuers.toml")


def record(path: Path, *, rate_hz: float) -> Recording:
    """Ten seconds in the air, five of them in pursuit, with states and targets at `rate_hz`."""
    with Recorder(path, buffer_messages=100_000) as recorder:
        for start_s, phase in ((0.0, "takeoff"), (5.0, "pursue"), (10.0, "done")):
            recorder.log("/phase", messages.Phase(T0_S + start_s, phase, "", None), T0_S + start_s)
        log_steps(recorder, int(10 * rate_hz), rate_hz)
        recorder.log("/own", own(T0_S + 20.0), T0_S + 20.0)
    return read_recording(path)


def test_full_rates_are_good(tmp_path: Path) -> None:
    findings = {finding.topic: finding for finding in check_rates(record(tmp_path / "p1.mcap", rate_hz=25.0))}
    for topic, window_s in (("/own", 10.0), ("/obstacles", 10.0), ("/target", 5.0)):
        assert findings[topic].good
        assert findings[topic].measured_hz == pytest.approx(25.0)
        assert findings[topic].window_s == pytest.approx(window_s)
    assert not findings["/decision"].good
    assert findings["/decision"].measured_hz == 0.0
    assert "/event" not in findings
    assert "/truth" not in findings


def test_a_slow_channel_is_found(tmp_path: Path) -> None:
    findings = {finding.topic: finding for finding in check_rates(record(tmp_path / "p1.mcap", rate_hz=19.0))}
    assert not findings["/own"].good
    assert str(findings["/own"]) == "/own: 19.0 Hz of 25 Hz over 10.0 s"


def test_the_evader_promises_neither_target_nor_obstacles(tmp_path: Path) -> None:
    recording = record(tmp_path / "e1.mcap", rate_hz=25.0)
    topics = {finding.topic for finding in check_rates(recording, MISSION.vehicle("e1"))}
    assert "/own" in topics
    assert not topics & {"/target", "/obstacles"}


def test_without_a_flight_nothing_is_promised(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        log_steps(recorder, 5)
    assert check_rates(read_recording(tmp_path / "p1.mcap")) == ()
