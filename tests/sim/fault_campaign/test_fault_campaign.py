"""The campaign as a person calls it: what it prints, keeps and returns, and that a seed is the same every time."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.config.mission import load_mission
from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording
from flightapp.sim.fault_campaign import drawing, flight
from flightapp.sim.fault_campaign.drawing import draw
from flightapp.sim.fault_campaign.flight import Verdict, fly_seed
from flightapp.sim.fault_campaign.kinds import KINDS
from flightapp.sim.fault_campaign.plan import Injection, Moment, Plan
from flightapp.sim.fault_campaign.trace import Finding, Trace
from tests.sim.fault_campaign.traces import DEMO, ROOT

SIM = ROOT / "profiles/sim.toml"


@pytest.fixture
def short_hover(tmp_path: Path) -> Path:
    """Missions that are cheap to fly: one vehicle up, five seconds of hovering, and down."""
    text = (ROOT / "missions/hover.toml").read_text()
    assert "time_limit_s = 60.0" in text
    path = tmp_path / "short_hover.toml"
    path.write_text(text.replace("time_limit_s = 60.0", "time_limit_s = 5.0"))
    return path


def call(*arguments: str) -> tuple[int, str]:
    """Exit status and standard output."""
    result = CliRunner().invoke(app, ["campaign", "faults", "--profile", str(SIM), *arguments])
    if isinstance(result.exception, InputError):
        raise result.exception
    return result.exit_code, result.stdout


def test_seeds_give_the_same_answer_again_whatever_the_workers(tmp_path: Path, short_hover: Path) -> None:
    common = ("--mission", str(short_hover), "--seeds", "3-4", "--json")
    status, text = call(*common, "--workers", "1", "--out", str(tmp_path / "one"))
    again, text_again = call(*common, "--workers", "2", "--out", str(tmp_path / "two"))
    summary, summary_again = json.loads(text), json.loads(text_again)
    assert summary.pop("seconds") > 0.0
    assert summary_again.pop("seconds") > 0.0
    assert summary == summary_again
    assert status == again == (1 if summary["violations"] else 0)
    assert summary["missions"] == 2
    flown = [json.loads((tmp_path / name / "missions.json").read_text())["flown"] for name in ("one", "two")]
    assert flown[0] == flown[1]


def test_a_violation_is_exit_status_1_and_keeps_its_recording(
    tmp_path: Path, short_hover: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never_holds(trace: Trace) -> Iterator[Finding]:
        if trace.seed == 1:
            yield Finding("e1", 1.5, "on purpose")

    monkeypatch.setattr(flight, "INVARIANTS", {"broken": never_holds})
    monkeypatch.setattr(drawing, "KINDS", {"operator land": KINDS["operator land"]})
    status, text = call(
        "--mission", str(short_hover), "--seeds", "0-1", "--workers", "1", "--json", "--out", str(tmp_path / "out")
    )
    assert status == 1
    (violation,) = json.loads(text)["violations"]
    recording = violation.pop("recording")
    assert violation == {"seed": 1, "invariant": "broken", "vehicle": "e1", "time_s": 1.5, "text": "on purpose"}
    assert len(read_recording(tmp_path / "out" / recording).topic("/own")) > 0
    assert [path.name for path in (tmp_path / "out").iterdir() if path.is_dir()] == ["seed-1"]


def flown_with(mission: Path, monkeypatch: pytest.MonkeyPatch, injection: Injection) -> Verdict:
    """One mission with one fault."""
    plan = Plan(0, load_mission(mission), (injection,))
    monkeypatch.setattr(flight, "draw", lambda *_, **__: plan)
    return fly_seed(0, mission, SIM, mission.parent / "run", varies=False)


def test_a_killed_process_leaves_a_recoverable_recording_and_a_vehicle_on_the_ground(
    tmp_path: Path, short_hover: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    verdict = flown_with(short_hover, monkeypatch, Injection("killed", "e1", Moment.PURSUIT, 1.0, None))
    assert verdict.injections == (("killed", "e1", "felt"),)
    assert verdict.violations == ()
    assert (tmp_path / "run/e1.recovered.mcap").exists()


def test_a_climb_that_is_not_seen_is_not_taken_for_a_pilots_hold(short_hover: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Found by seed 1: with old telemetry the app let go of a vehicle that nobody flew, and it hovered for ever."""
    verdict = flown_with(short_hover, monkeypatch, Injection("telemetry off", "e1", Moment.TAKEOFF, 0.5, 8.0))
    assert verdict.injections == (("telemetry off", "e1", "felt"),)
    assert verdict.outcomes == (("e1", "timeout"),)
    assert verdict.violations == ()


def test_a_fault_whose_moment_never_comes_is_reported_as_not_begun(short_hover: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flight, "TIME_LIMIT_S", 5.0)
    verdict = flown_with(short_hover, monkeypatch, Injection("killed", "e1", Moment.WAY_HOME, 0.0, None))
    assert verdict.injections == (("killed", "e1", "not begun"),)
    assert [violation.invariant for violation in verdict.violations] == ["on the ground"]


def test_seeds_draw_every_kind_and_every_moment_and_missions_that_differ() -> None:
    mission = load_mission(DEMO)
    plans = [draw(seed, mission, varies=True) for seed in range(200)]
    assert {one.kind for plan in plans for one in plan.injections} == set(KINDS)
    assert {one.moment for plan in plans for one in plan.injections} == set(Moment)
    assert all(1 <= len(plan.injections) <= 3 for plan in plans)
    assert {len(plan.mission.vehicles) for plan in plans} == {3, 4}
    assert max(len(plan.mission.obstacles.cylinders) for plan in plans) > len(mission.obstacles.cylinders)
    assert plans[7] == draw(7, mission, varies=True)
    assert replace(plans[7], mission=mission).mission == draw(7, mission, varies=False).mission


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--seeds", "9-3"), ["--seeds 9-3", "write 3-9"]),
        (("--seeds", "many"), ["--seeds many", "is not a seed"]),
        (("--workers", "0"), ["--workers 0", "at least 1"]),
        (("--mission", "none.toml"), ["none.toml: no such file"]),
        (("--out", str(ROOT / "missions")), ["--out", "is not empty; name a new folder"]),
    ],
)
def test_bad_arguments_are_one_clear_sentence(
    arguments: tuple[str, ...], told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    with pytest.raises(InputError) as raised:
        call(*arguments)
    assert all(part in str(raised.value) for part in told)
    assert "\n" not in str(raised.value)
