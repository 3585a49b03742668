"""Reading: a log that was cut off is read up to the cut; what is no log is one sentence."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.flight import examine
from flightapp.analysis.ulog.log import load_log
from flightapp.analysis.ulog.report import report_log
from flightapp.cli import app
from flightapp.core.errors import InputError
from tests.analysis.ulog.flights import clean_flight

CLEAN = clean_flight().content()


def test_a_log_cut_off_in_the_air_is_read_up_to_the_cut(tmp_path: Path) -> None:
    path = tmp_path / "cut.ulg"
    path.write_bytes(CLEAN[: len(CLEAN) // 2])
    examined = examine(path)
    assert 20.0 < examined.log.end_s < 40.0
    assert "the log ends in the air" in [finding.title for finding in examined.findings if finding.severity == Severity.FAILURE]


@pytest.mark.parametrize(
    ("content", "wanted"),
    [
        (b"", "not a PX4 log"),
        (b"garbage" * 1000, "not a PX4 log"),
        (b"\x89MCAP0\r\n" + bytes(5000), "not a PX4 log"),
        (CLEAN[:16], "holds no data"),
        (CLEAN[:600], "holds no data"),
    ],
)
def test_what_is_no_log_is_one_sentence(tmp_path: Path, content: bytes, wanted: str) -> None:
    path = tmp_path / "bad.ulg"
    path.write_bytes(content)
    with pytest.raises(InputError, match=wanted) as caught:
        load_log(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        load_log(tmp_path / "none.ulg")


@settings(max_examples=60, deadline=None)
@given(
    places=st.lists(st.tuples(st.integers(0, len(CLEAN) - 1), st.integers(0, 255)), min_size=1, max_size=20),
    end=st.integers(0, len(CLEAN)),
)
def test_damaged_bytes_never_break_the_reader(
    tmp_path_factory: pytest.TempPathFactory, places: list[tuple[int, int]], end: int
) -> None:
    content = bytearray(CLEAN)
    for place, value in places:
        content[place] = value
    path = tmp_path_factory.mktemp("ulog") / "mutant.ulg"
    path.write_bytes(content[:end])
    sentence: str = ""
    findings: tuple[Finding, ...] = ()
    try:
        findings = examine(path).findings
    except InputError as error:
        sentence = str(error)
    assert bool(findings) != bool(sentence)
    assert "\n" not in sentence


def test_the_report_of_a_log_is_a_page_that_needs_no_network_and_a_summary(tmp_path: Path) -> None:
    log = clean_flight()
    times, _ = log.topics["vehicle_gps_position"]
    log.change("vehicle_gps_position", jamming_indicator=np.where(times > 20.0, 120.0, 5.0))
    log.messages.append((20.0, 3, "[x] <script>alert(1)</script>"))
    told = report_log(log.write(tmp_path / "flight.ulg"), tmp_path / "out")
    page = told.page.read_text()
    assert told.page == tmp_path / "out" / "flight-report.html"
    assert "GPS interference" in page
    assert "<script>alert" not in page
    assert 'src="http' not in page
    summary = json.loads((tmp_path / "out" / "flight-summary.json").read_text())
    assert summary["verdict"] == "failure"
    assert "GPS interference" in [finding["title"] for finding in summary["findings"]]
    assert "GPS interference" in told.text()


def test_the_command_line_takes_one_log(tmp_path: Path) -> None:
    path = clean_flight().write(tmp_path / "flight.ulg")
    done = CliRunner().invoke(app, ["report", str(path), "--json"])
    assert done.exit_code == 0
    assert json.loads(done.output)["verdict"] == "ok"
    assert (tmp_path / "flight-report.html").is_file()
    mixed = CliRunner().invoke(app, ["report", str(path), str(tmp_path / "p1.mcap")])
    assert "name one .ulg alone" in str(mixed.exception)
