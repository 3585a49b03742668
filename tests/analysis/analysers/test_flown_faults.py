"""Every analyser is silent on a clean run, and finds the fault that it is there for. Most faults are flown, some edited in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flightapp.analysis.analysers import ANALYSERS
from flightapp.analysis.analysers.oscillation import reversals
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.run import Run, load_run
from flightapp.analysis.summary import summarise
from flightapp.analysis.verdict import verdict_of
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_campaign.effects import CutOff, Filmed, Hung, Piloted, Planning, Scripted, Site, WrongClock
from tests.analysis.analysers.demo_flights import Flaps, Injection, changed, findings_of, fly, serious

CLOCK_STEP_S = 0.8


class SlowPlanning(Planning):
    """One decision after another takes a quarter of a second, six control periods."""

    def begin(self, site: Site) -> None:
        site.planner.long_s = 0.25
        super().begin(site)


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """To the capture and half of the way home: what is left is the autopilot's own landing, and costs as much again."""
    return fly(tmp_path_factory.mktemp("clean") / "run", ends_s=19.0)


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Several faults that do not hide one another."""
    return fly(
        tmp_path_factory.mktemp("faulty") / "run",
        Injection("p1", 1.0, 0.7, Filmed("off")),
        Injection("p2", 1.5, 0.3, SlowPlanning("slow")),
        Injection("p2", 3.0, 1.7, CutOff()),
        Injection("e1", 5.5, 4.0, Flaps()),
        Injection("p1", 5.0, 6.0, Scripted("motors", "wrong", 6.0, {"acceleration_m_s2": 4.0})),
        Injection("p2", 9.0, 9.0, Piloted(Mode.POSCTL)),
        Injection("p1", 11.0, 9.0, Scripted("battery", "wrong", None, {"remaining": 0.15})),
        ends_s=13.0,
    )


@pytest.fixture(scope="module")
def shifted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The clock of p2 is ahead from the start; p1 sees nothing for a while, and at last its process hangs."""
    return fly(
        tmp_path_factory.mktemp("shifted") / "run",
        Injection("p2", None, 1.0, WrongClock(CLOCK_STEP_S)),
        Injection("p1", 4.0, 3.0, Filmed("blind")),
        Injection("p1", 9.0, 1.0, Hung()),
        ends_s=11.0,
    )


@pytest.fixture(scope="module")
def of_clean(clean: Path) -> tuple[Finding, ...]:
    return findings_of(clean)


@pytest.fixture(scope="module")
def of_faulty(faulty: Path) -> tuple[Finding, ...]:
    return findings_of(faulty)


@pytest.fixture(scope="module")
def of_shifted(shifted: Path) -> tuple[Finding, ...]:
    return findings_of(shifted)


@pytest.mark.parametrize("analyser", [analyser.name for analyser in ANALYSERS])
def test_a_clean_run_has_nothing_to_complain_of(of_clean: tuple[Finding, ...], analyser: str) -> None:
    assert [one for one in of_clean if one.analyser == analyser], "silence would look like health"
    assert serious(of_clean, analyser) == []
    assert not [one for one in of_clean if one.analyser == analyser and one.title == "not known"]


def test_a_clean_run_has_a_good_verdict(clean: Path) -> None:
    summary = summarise(load_run([clean]))
    assert summary["verdict"] == "good"
    assert summary["headline"].endswith("no failures or warnings")
    assert {one["analyser"] for one in summary["findings"]} == {analyser.name for analyser in ANALYSERS}


@pytest.mark.parametrize(
    ("vehicle", "analyser", "title", "evidence", "least", "most"),
    [
        ("p1", "perception", "depth frames missing", "gap_s", 0.65, 1.5),
        ("p2", "offboard", "gap in the setpoints", "gap_s", 0.24, 0.35),
        ("p2", "planner", "decisions late", "latency_max_s", 0.25, 0.3),
        ("p2", "link", "teammate silent", "age_max_s", 1.6, 1.9),
        ("p1", "link", "teammate silent", "age_max_s", 1.6, 1.9),
        ("p2", "target", "evader lost", "lost_s", 1.6, 1.9),
        ("e1", "oscillation", "mode flaps", "changes", 6, 20),
        ("e1", "oscillation", "setpoint swings", "reversals", 7, 12),
        ("p1", "saturation", "setpoint not followed", "longest_s", 1.0, 6.0),
        ("p1", "battery", "reserve used", "left_fraction", 0.14, 0.16),
        ("p1", "battery", "charge fell suddenly", "fall_fraction", 0.7, 0.9),
        ("p2", "offboard", "offboard left", "", 0, 0),
        ("p1", "failsafe", "degraded: camera lost", "", 0, 0),
    ],
)
def test_a_flown_fault_is_found(
    of_faulty: tuple[Finding, ...], vehicle: str, analyser: str, title: str, evidence: str, least: float, most: float
) -> None:
    found = [one for one in serious(of_faulty, analyser, vehicle) if one.title == title]
    assert found
    for one in found:
        assert one.from_s is not None
        assert not evidence or least <= float(one.evidence[evidence]) <= most


def test_blindness_and_the_end_of_a_process_are_found(of_shifted: tuple[Finding, ...]) -> None:
    (blind,) = serious(of_shifted, "perception", "p1")
    assert blind.title == "blind"
    assert float(blind.evidence["blind_s"]) == pytest.approx(3.0, abs=0.1)
    assert [one.severity for one in serious(of_shifted, "offboard", "p1") if one.title == "ends in offboard"] == [
        Severity.FAILURE
    ]


def error_of_what_was_heard_m(run: Run) -> float:
    """Where p1 heard p2 to be, against where p2 itself was at that time of the common time base."""
    p1, p2 = (next(one for one in run.vehicles if one.name == name) for name in ("p1", "p2"))
    heard, track = Subject(run, p1).heard["p2"], p2.track
    assert track is not None
    then_s = heard.t_s - heard.age_s
    known = (then_s > track.t_s[0]) & (then_s < track.t_s[-1])
    assert np.count_nonzero(known) > 50
    return float(np.linalg.norm(track.at(then_s[known]).position_ned_m - heard.position_ned_m[known], axis=1).max())


def test_a_wrong_clock_is_corrected_by_what_was_measured(shifted: Path, of_shifted: tuple[Finding, ...], tmp_path: Path) -> None:
    run = load_run([shifted])
    shifts = {vehicle.name: vehicle.shift_s for vehicle in run.vehicles}
    assert shifts["p2"] - shifts["p1"] == pytest.approx(-CLOCK_STEP_S, abs=0.02)
    assert error_of_what_was_heard_m(run) < 0.2
    assert serious(of_shifted, "clock") == []

    untold = changed(shifted, tmp_path / "untold", {}, lambda _: None)
    assert error_of_what_was_heard_m(load_run([untold])) > 1.0  # The correction was needed.
    notes = [one for one in findings_of(untold) if one.title == "offset not measured"]
    assert {one.vehicle for one in notes} == {"p1", "p2", "e1"}


def older(by_s: float, from_s: float = 0.0) -> Any:
    """Everybody's states seem older by `by_s` from `from_s` on."""

    def change(message: dict[str, Any]) -> dict[str, Any]:
        if message["t_s"] >= from_s:
            for member in message["members"]:
                member["age_s"] += by_s
        return message

    return change


def test_clocks_that_differ_unnoticed_or_jump_are_found(clean: Path, tmp_path: Path) -> None:
    differ = serious(findings_of(changed(clean, tmp_path / "differ", {("p1", "/team"): older(0.4)})), "clock")
    assert {(one.vehicle, one.title) for one in differ} == {("p1", "clocks differ")}
    assert float(differ[0].evidence["offset_s"]) == pytest.approx(-0.4, abs=0.1)
    jump = serious(findings_of(changed(clean, tmp_path / "jump", {("p2", "/team"): older(-0.15, 1020.0)})), "clock")
    assert {(one.vehicle, one.title) for one in jump} == {("p2", "clock jumped")}
    assert float(jump[0].evidence["step_s"]) == pytest.approx(-0.15, abs=0.05)
    assert jump[0].from_s == pytest.approx(1020.0, abs=4.0)


def moved(north_m: float, east_m: float, down_m: float) -> Any:
    """Everything that a vehicle says of its own place is off by so much."""

    def change(message: dict[str, Any]) -> dict[str, Any]:
        offset = (north_m, east_m, down_m)
        message["position_ned_m"] = [value + by for value, by in zip(message["position_ned_m"], offset, strict=True)]
        return message

    return change


@pytest.mark.parametrize(
    ("east_m", "down_m", "title"),
    [
        (30.0, 0.0, "outside the contingency volume"),
        (24.0, 0.0, "outside the flight volume"),
        (0.0, -8.0, "above the height band"),
    ],
)
def test_a_vehicle_beyond_the_fence_is_found(clean: Path, tmp_path: Path, east_m: float, down_m: float, title: str) -> None:
    found = serious(findings_of(changed(clean, tmp_path / "run", {("p2", "/own"): moved(0.0, east_m, down_m)})), "fence")
    assert [(one.vehicle, one.title, one.severity) for one in found] == [("p2", title, Severity.FAILURE)]


def test_lost_separation_is_found_also_without_the_others_recording(clean: Path, tmp_path: Path) -> None:
    run = load_run([clean])
    tracks = {vehicle.name: vehicle.track for vehicle in run.vehicles}
    p1, p2 = tracks["p1"], tracks["p2"]
    assert p1 is not None
    assert p2 is not None
    at = np.array([1012.0])
    offset = (p1.at(at).position_ned_m - p2.at(at).position_ned_m)[0] + (1.0, 0.0, 0.0)

    def all_of_p2(message: dict[str, Any]) -> dict[str, Any]:
        for member in message["members"]:
            if member["name"] == "p2":
                moved(*offset.tolist())(member)
        return message

    close = changed(clean, tmp_path / "close", {("p2", "/own"): moved(*offset.tolist()), ("p1", "/team"): all_of_p2})
    (found,) = serious(findings_of(close), "separation")
    assert (found.severity, found.evidence["other"]) == (Severity.FAILURE, "p2")
    (close / "p2.mcap").unlink()
    (alone,) = serious(findings_of(close), "separation")
    assert float(alone.evidence["distance_m"]) == pytest.approx(float(found.evidence["distance_m"]), abs=0.2)


def test_near_misses_are_found(clean: Path, tmp_path: Path) -> None:
    run = load_run([clean])
    tracks = {vehicle.name: vehicle.track for vehicle in run.vehicles}
    p1, e1 = tracks["p1"], tracks["e1"]
    assert p1 is not None
    assert e1 is not None
    at = np.array([1012.0])
    to_evader = (e1.at(at).position_ned_m - p1.at(at).position_ned_m)[0] + (0.0, 1.0, 0.0)
    tree = np.array([24.0, -2.0, p1.at(at).position_ned_m[0, 2]]) - p1.at(at).position_ned_m[0]
    for offset, title in ((to_evader, "inside the evader's keep-out"), (tree, "contact with an obstacle")):
        near = changed(clean, tmp_path / title, {("p1", "/own"): moved(*offset.tolist())})
        assert title in [one.title for one in serious(findings_of(near), "near miss", "p1")]

    def brushing(message: dict[str, Any]) -> dict[str, Any]:
        return message | {"clearance_m": 0.05}

    seen = serious(findings_of(changed(clean, tmp_path / "seen", {("p2", "/setpoint"): brushing})), "near miss")
    assert [(one.vehicle, one.severity, one.title) for one in seen] == [("p2", Severity.WARNING, "near miss of an obstacle")]


def test_a_wrong_estimate_and_a_planner_that_is_not_asked_are_found(clean: Path, tmp_path: Path) -> None:
    def silent(message: dict[str, Any]) -> dict[str, Any] | None:
        return None if 1009.0 < message["t_s"] < 1010.0 else message

    found = findings_of(changed(clean, tmp_path / "run", {("p1", "/target"): moved(8.0, 0.0, 0.0), ("p2", "/decision"): silent}))
    assert [one.title for one in serious(found, "target", "p1")] == ["estimate wrong"]
    (gap,) = serious(found, "planner", "p2")
    assert float(gap.evidence["silent_s"]) == pytest.approx(1.0, abs=0.1)


def test_what_was_not_recorded_is_not_known(clean: Path, tmp_path: Path) -> None:
    less = changed(clean, tmp_path / "run", {("p1", topic): lambda _: None for topic in ("/battery", "/team", "/decision")})
    unknown = {(one.vehicle, one.analyser) for one in findings_of(less) if one.title == "not known"}
    assert {("p1", name) for name in ("battery", "link", "clock", "separation", "planner", "oscillation")} == unknown
    for path in less.glob("*.toml"):
        path.unlink()
    bare = findings_of(less)
    assert {one.analyser for one in bare if one.vehicle == "p2" and one.title == "not known"} >= {"fence", "battery", "link"}


def test_a_cut_and_a_missing_recording_are_examined_with_what_there_is(clean: Path, tmp_path: Path) -> None:
    for path in clean.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    content = (tmp_path / "p1.mcap").read_bytes()
    (tmp_path / "p1.mcap").write_bytes(content[: len(content) // 3])
    (tmp_path / "p2.mcap").unlink()
    (heard,) = serious(findings_of(tmp_path), "offboard")
    assert (heard.vehicle, heard.title) == ("p1", "recording cut off")  # The evader heard it go on.
    (tmp_path / "e1.mcap").unlink()
    summary = summarise(load_run([tmp_path]))
    assert [one["title"] for one in summary["findings"] if one["severity"] == "failure"] == ["ends in offboard"]
    assert verdict_of(summary).level == "bad"


def test_folders_of_several_computers_are_one_run(clean: Path, tmp_path: Path) -> None:
    folders = []
    for name in ("p1", "p2", "e1"):
        folders.append(tmp_path / f"from-{name}")
        folders[-1].mkdir()
        for file in (f"{name}.mcap", "mission.toml", "profile.toml"):
            (folders[-1] / file).write_bytes((clean / file).read_bytes())
    (folders[1] / "p2-cut.mcap").write_bytes((clean / "p2.mcap").read_bytes()[:200_000])
    run = load_run(folders)
    assert {vehicle.name for vehicle in run.vehicles} == {"p1", "p2", "e1"}
    assert [(path.name, why.split(":")[0]) for path, why in run.unreadable] == [("p2-cut.mcap", "not used")]
    together, apart = summarise(run), summarise(load_run([clean]))
    assert together["min_separation_m"] == apart["min_separation_m"]


def test_turning_points_are_counted_and_wiggles_are_not() -> None:
    t_s = np.arange(0.0, 10.0, 0.04)
    swinging = np.sin(2 * np.pi * t_s) + 0.05 * np.sin(40 * t_s)
    assert 19 <= len(reversals(swinging, 1.0)) <= 20  # Two turns in each of ten periods.
    assert reversals(0.4 * swinging, 1.0) == []
    assert reversals(t_s, 1.0) == []
