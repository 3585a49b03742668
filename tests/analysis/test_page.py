"""report.html as a file: what stands in it, that it needs nothing else, and that its numbers are the run's. No browser needed."""

import base64
import itertools
import json
import re
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from typer.testing import CliRunner

from flightapp.analysis.comparison import comparison_section, differences
from flightapp.analysis.export import held
from flightapp.analysis.findings import Finding, Severity, as_json, of_json
from flightapp.analysis.findings_section import findings_section, log_findings
from flightapp.analysis.packed import spread_out, thinned
from flightapp.analysis.run import load_run
from flightapp.analysis.spells import Spell, guard_spells, mode_spells
from flightapp.analysis.ulog.beside import LogBeside
from flightapp.analysis.ulog.flight import ExaminedLog
from flightapp.analysis.ulog.log import FlightLog
from flightapp.cli import app
from flightapp.core.types import Array
from tests.analysis.synthetic_run import CAPTURED_S, MOTIONS, PURSUE_S, T0_S

SECTIONS = {
    "verdict",
    "findings",
    "comparison",
    "map-section",
    "map",
    "lanes",
    "slider",
    "play",
    "over-time",
    "events",
    "vehicles",
}
FAR_S = 30.0


@dataclass
class Page(HTMLParser):
    """What a browser would see of the file without running it."""

    ids: list[str] = field(default_factory=list)
    addresses: list[str] = field(default_factory=list)
    data: dict[str, Any] = field(default_factory=dict)
    open_tags: list[str] = field(default_factory=list)
    text: str = ""
    _data_id: str | None = None

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        told = dict(attributes)
        if "id" in told:
            self.ids.append(str(told["id"]))
        self.addresses += [str(told[name]) for name in ("src", "href", "action", "data", "poster", "srcset") if name in told]
        self._data_id = told.get("id") if told.get("type") == "application/json" else None
        if tag not in ("meta", "input", "br"):
            self.open_tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open_tags.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._data_id is not None and self.open_tags[-1] == "script":
            self.data[self._data_id] = json.loads(data)
        elif self.open_tags and self.open_tags[-1] not in ("script", "style"):
            self.text += data


@pytest.fixture(scope="module")
def run(reported_run: Path) -> Path:
    return reported_run


@pytest.fixture(scope="module")
def page(run: Path) -> Page:
    parsed = Page()
    parsed.feed((run / "report.html").read_text())
    parsed.close()
    return parsed


def test_it_is_whole_and_has_its_sections(page: Page) -> None:
    assert page.open_tags == []
    assert set(page.ids) >= SECTIONS
    assert len(page.ids) == len(set(page.ids))
    assert "The evader was captured after 33.0 s" in page.text


def test_it_needs_nothing_from_anywhere(run: Path, page: Page) -> None:
    text = (run / "report.html").read_text()
    assert page.addresses == []
    assert "default-src 'none'" in text
    assert not re.search(r"@import|url\(", text[text.index("<style>") : text.index("</style>")])
    assert len(text) < 8_000_000


def test_what_is_played_is_the_run(page: Page) -> None:
    playback = page.data["playback"]
    assert playback["origin"] == "pursuit"
    assert playback["capture"]["t"] == pytest.approx(CAPTURED_S - PURSUE_S, abs=0.05)
    assert {one["name"]: one["role"] for one in playback["vehicles"]} == {"p1": "pursuer", "p2": "pursuer", "e1": "evader"}
    for one in playback["vehicles"]:
        t_s, north, east = (unpacked(one["way"][name]) for name in ("t", "north", "east"))
        index = int(np.argmin(np.abs(t_s - FAR_S)))
        expected = MOTIONS[one["name"]].position(PURSUE_S + float(t_s[index]))
        assert [north[index], east[index]] == pytest.approx(expected[:2].tolist(), abs=0.02)
    pursuer = next(one for one in playback["vehicles"] if one["name"] == "p1")
    assert all(pursuer[part] is not None for part in ("estimate", "setpoint", "discs"))
    start = unpacked(pursuer["discs"]["start"])
    assert start[-1] * 3 == len(unpacked(pursuer["discs"]["rows"]))
    assert len(start) == len(unpacked(pursuer["discs"]["t"])) + 1


def test_the_other_run_is_a_ghost(page: Page) -> None:
    (ghost,) = page.data["playback"]["ghosts"]
    assert ghost["name"] == "B: shorter"
    assert {one["name"] for one in ghost["vehicles"]} == {"p1", "e1"}
    assert "incomplete" not in page.text  # the verdict is on this run, not on the other


def test_every_figure_has_a_place_and_shares_the_line(page: Page) -> None:
    figures = page.data["figures"]
    assert set(figures["figures"]) <= set(page.ids)
    assert set(figures["shared"]) == set(figures["figures"])
    ranges = {tuple(figure["layout"]["xaxis"]["range"]) for figure in figures["figures"].values()}
    assert len(ranges) == 1
    for title in ("Jerk", "Clearance to obstacles", "Frame to setpoint", "Error of the target estimate", "Battery"):
        assert title in page.text


@pytest.fixture
def findings() -> list[Finding]:
    span = (T0_S + 20.0, T0_S + 21.5)
    return [
        Finding("link", Severity.OK, "heard <b>", "All is well.", vehicle="p1"),
        Finding("battery", Severity.WARNING, "reserve used", "15 % was left.", T0_S + 40.0, T0_S + 40.0, {"left_fraction": 0.15}),
        Finding("separation", Severity.FAILURE, "separation lost", "Too close.", *span, {"least_m": 0.8123456}, "p2"),
        Finding("clock", Severity.NOTE, "not known", "No clock was recorded.", evidence={"known": "no"}, vehicle="p1"),
        Finding("clock", Severity.NOTE, "not known", "No clock was recorded.", evidence={"known": "no"}, vehicle="p2"),
    ]


def test_the_worst_stands_first_with_time_and_evidence(findings: list[Finding]) -> None:
    text = findings_section(findings, T0_S)
    assert text.index("separation lost") < text.index("reserve used") < text.index("not-known") < text.index("<details>")
    assert 'data-t="20.000"' in text
    assert "least_m 0.8123" in text
    assert "1 failure, 1 warning, 0 notes, 2 not known, 1 fine" in text
    assert "heard &lt;b&gt;" in text[text.index("<details>") :]


def test_what_is_not_known_is_not_folded_away(findings: list[Finding]) -> None:
    text = findings_section(findings, T0_S)
    shown = text[: text.index("<details>")]
    assert shown.count("No clock was recorded.") == 1
    assert "p1, p2" in shown


def test_what_an_autopilots_log_warns_of_stands_there_without_a_time_it_has_not() -> None:
    told = (
        Finding("power", Severity.WARNING, "5 V rail low", "4.6 V.", 1.0, 2.0),
        Finding("battery", Severity.OK, "fine", "Full.", 1.0, 2.0),
    )
    examined = ExaminedLog(cast(FlightLog, None), told, ())
    found = log_findings([LogBeside(Path("foreign.ulg"), examined, unaligned="no vehicle moved as it did")])
    assert [(one.vehicle, one.analyser, one.from_s) for one in found] == [
        ("foreign.ulg", "PX4 log", None),
        ("foreign.ulg", "PX4 log, power", None),
    ]


def test_findings_survive_the_summary(findings: list[Finding]) -> None:
    assert [of_json(as_json(one)) for one in findings] == findings


def test_differences_are_other_minus_this(run: Path) -> None:
    summary = json.loads((run / "summary.json").read_text())
    other = summary | {"capture_time_s": summary["capture_time_s"] + 2.0, "min_separation_m": None, "mean_jerk_m_s3": None}
    row = {one["figure"]: one for one in differences(summary, {"B": other})}
    assert row["capture_time_s"]["others"]["B"]["difference"] == pytest.approx(2.0)
    assert row["min_separation_m"]["others"]["B"] == {"value": None, "difference": None}
    text = comparison_section(summary, {"B <i>": other}, [])
    assert "35.0 (+2.0)" in text
    assert "B &lt;i&gt;" in text
    assert comparison_section(summary, {}, []) == ""
    assert summary["compared"][0]["others"].keys() == {"B: shorter"}


def test_the_table_has_every_series_on_one_time_base(run: Path) -> None:
    table = pyarrow.parquet.read_table(run / "series.parquet")
    assert pyarrow.csv.read_csv(run / "series.csv").column_names == table.column_names
    t_s = table["t_s"].to_numpy()
    assert np.diff(t_s) == pytest.approx(0.04, abs=1e-6)
    bare = [name for name in table.column_names if not re.search(r"_(s|m|m_s|m_s3|ms|percent|V|MB)$", name)]
    assert {name.partition(".")[2] for name in bare} == {"phase", "mode", "guards"}
    row = int(np.searchsorted(t_s, T0_S + FAR_S))
    expected = MOTIONS["e1"].position(float(t_s[row]) - T0_S)
    assert [table[f"e1.true.{axis}_m"][row].as_py() for axis in ("north", "east", "down")] == pytest.approx(expected, abs=0.02)
    assert table["p1.phase"][row].as_py() == "pursue"
    assert table["p1.mode"][row].as_py() in ("approach", "coarse", "fine")
    assert table["p1.setpoint_gap_ms"][0].as_py() is None


def test_a_wrong_run_to_compare_with_leaves_the_report_as_it_was(run: Path, tmp_path: Path) -> None:
    before = {path.name: path.stat().st_mtime_ns for path in run.iterdir()}
    told = CliRunner().invoke(app, ["report", str(run), "--compare", str(tmp_path), "--csv"])
    assert told.exit_code != 0
    assert "no recording" in str(told.exception)
    assert {path.name: path.stat().st_mtime_ns for path in run.iterdir()} == before
    (tmp_path / "flight.ulg").write_bytes(b"")
    told = CliRunner().invoke(app, ["report", str(tmp_path / "flight.ulg"), "--csv"])
    assert "are for recordings" in str(told.exception)


def test_spells_follow_what_was_recorded(run: Path) -> None:
    vehicle = next(one for one in load_run([run]).vehicles if one.name == "p1")
    modes = mode_spells(vehicle)
    assert [spell.name for spell in modes] == list(dict.fromkeys(vehicle.recording.topic("/decision").texts("mode")))
    assert all(first.to_s == second.from_s for first, second in itertools.pairwise(modes))
    setpoints = vehicle.recording.topic("/setpoint")
    for t_s, acting in zip(setpoints.t_s.tolist(), setpoints.values("acting"), strict=True):
        for guard, _ in acting:
            assert any(covers(spell, guard, t_s) for spell in guard_spells(vehicle))


def covers(spell: Spell, guard: str, t_s: float) -> bool:
    return spell.name == guard and spell.from_s <= t_s <= spell.to_s


@given(arrays(np.float64, st.integers(1, 400), elements=st.floats(-1e6, 1e6)), st.integers(2, 60))
def test_what_is_thinned_out_keeps_its_extremes(values: Array, points_max: int) -> None:
    t_s = np.arange(len(values)) * 0.1
    thin_t_s, thin = thinned(t_s, values, points_max)
    assert len(thin) <= max(points_max, 2)
    assert (thin.min(), thin.max()) == (values.min(), values.max())
    assert np.all(np.diff(thin_t_s) >= 0.0)
    assert set(thin_t_s) <= set(t_s)


def test_what_was_not_known_stays_a_gap() -> None:
    values = np.full(1000, 1.0)
    values[400:600] = np.nan
    _, thin = thinned(np.arange(1000.0), values, 100)
    assert np.isnan(thin[40:60]).all()
    assert np.isfinite(np.delete(thin, np.arange(40, 60))).all()


@given(st.lists(st.floats(0.001, 3.0), min_size=1, max_size=100), st.floats(0.01, 5.0))
def test_samples_are_spread_out_from_first_to_last(gaps: list[float], step_s: float) -> None:
    t_s = np.cumsum(gaps)
    chosen = spread_out(t_s, step_s)
    assert (chosen[0], chosen[-1]) == (0, len(t_s) - 1)
    assert len(chosen) <= (t_s[-1] - t_s[0]) / step_s + 2


def test_a_value_is_held_only_as_long_as_it_can_be_believed() -> None:
    known_t_s, values = np.array([10.0, 12.0, 14.0, 30.0]), np.array([1.0, 2.0, 3.0, 4.0])
    at = held(known_t_s, values, np.array([9.9, 10.0, 13.9, 19.9, 20.1, 30.0, 40.0]))
    assert at.tolist() == pytest.approx([np.nan, 1.0, 2.0, 3.0, np.nan, 4.0, np.nan], nan_ok=True)


def unpacked(told: dict[str, str]) -> Array:
    return np.frombuffer(base64.b64decode(told["bdata"]), dtype=f"<{told['dtype']}")
