"""flightapp replay: what differs is found and told, what does not is not, and bad input is one sentence."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flightapp import cli
from flightapp.core.errors import InputError
from flightapp.core.types import Decision, Observation
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.replay import Wanted, replay
from flightapp.replay.outcome import Replayed
from flightapp.safety.api import GuardVerdict
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual
from tests.replay.pieces import GOLDEN, PURSUER, changed
from tests.sim.virtual.played import Played, evader_path

ROOT = Path(__file__).parents[2]
TREE = ROOT / "tests/sim/virtual/beside_a_tree.toml"
TOLERANCE = 1e-9


def replayed(path: Path, **wanted: object) -> Replayed:
    [one] = replay(Wanted(path, **wanted)).replayed  # type: ignore[arg-type]
    return one


def test_a_flight_of_today_is_decided_bit_for_bit_the_same(tmp_path: Path) -> None:
    played = Played("e1", "evader", 3), Played("p2", "pursuer", 2)

    def play(fleet: VirtualFleet) -> None:
        played[0].play(fleet, evader_path(fleet.clock.now_s()))
        played[1].play(fleet, (-2.0, 9.0, -2.5))

    fly_virtual(TREE, ROOT / "profiles/sim.toml", tmp_path, seed=3, flown={"p1"}, watch=play, time_limit_s=22.0)
    one = replayed(tmp_path / "p1.mcap")
    assert one.decisions > 50, "the flight was too short to be a test"
    assert one.identical, one.text()


def test_a_planner_that_decides_otherwise_is_found_at_its_first_decision(monkeypatch: pytest.MonkeyPatch) -> None:
    decide, asked = Ac2fPlanner.step, 0

    def slower(planner: Ac2fPlanner, observation: Observation) -> Decision:
        nonlocal asked
        asked += 1
        decision = decide(planner, observation)
        return replace(decision, velocity_ned_m_s=decision.velocity_ned_m_s * 0.5, mode="fine") if asked == 40 else decision

    monkeypatch.setattr(Ac2fPlanner, "step", slower)
    one = replayed(PURSUER, tolerance=TOLERANCE)
    [found] = [difference for difference in one.differences if difference.of_decision]
    assert found.velocity_m_s > 0.1
    assert found.mode is not None
    assert found.mode[1] == "fine"
    assert one.summary()["decisions_differ"] == 1
    assert "velocity by" in one.text()


def test_a_supervisor_that_acts_otherwise_is_told_from_the_planner(monkeypatch: pytest.MonkeyPatch) -> None:
    check = SpeedGuard.check

    def meddling(guard: SpeedGuard, setpoint: object, context: object) -> GuardVerdict:
        return replace(check(guard, setpoint, context), reason="meddled")  # type: ignore[arg-type]

    monkeypatch.setattr(SpeedGuard, "check", meddling)
    one = replayed(PURSUER, tolerance=TOLERANCE)
    assert not any(difference.of_decision for difference in one.differences)
    assert len(one.differences) == one.setpoints
    guards = one.differences[0].guards
    assert guards is not None
    assert ("speed", "meddled") in guards[1]


def test_a_planner_that_fails_today_is_a_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(planner: Ac2fPlanner, observation: Observation) -> Decision:
        raise ValueError("nothing to see")

    monkeypatch.setattr(Ac2fPlanner, "step", broken)
    one = replayed(PURSUER)
    failures = [difference.failure for difference in one.differences if difference.failure]
    assert len(failures) == one.decisions
    assert failures[0] == ("", "ValueError: nothing to see")


def test_a_planner_that_failed_in_flight_and_still_does_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    failed = changed(tmp_path / "p1.mcap", without=("/decision",))
    assert any(difference.failure == ("the planner failed", "") for difference in replayed(failed).differences)

    def broken(planner: Ac2fPlanner, observation: Observation) -> Decision:
        raise ValueError("still")

    monkeypatch.setattr(Ac2fPlanner, "step", broken)
    assert not any(difference.failure for difference in replayed(failed).differences)


def test_another_planner_is_compared_open_loop() -> None:
    one = replayed(PURSUER, planner="geo-apf")
    assert not one.identical
    found = one.what_if
    assert found["decisions"] == one.decisions
    assert sum(second["velocity_apart_max_m_s"] > 0.0 for second in found["seconds"]) > 1
    assert found["modes_now"][0][1] == "coarse"
    assert 0.0 <= found["closing_faster_share"] <= 1.0
    assert "open loop" in one.text()


def test_other_parameters_are_compared_and_the_same_ones_are_identical(tmp_path: Path) -> None:
    file = tmp_path / "parameters.toml"
    file.write_text("lead = false\n")
    assert not replayed(PURSUER, parameters=file, tolerance=TOLERANCE).identical
    file.write_text("lead = true\n")
    same = replayed(PURSUER, parameters=file, tolerance=TOLERANCE)
    assert same.identical
    assert same.what_if["velocity_apart_mean_m_s"] < TOLERANCE
    file.write_text("leed = true\n")
    with pytest.raises(InputError, match="leed is not a parameter"):
        replayed(PURSUER, parameters=file)


def test_dropped_obstacles_are_told(tmp_path: Path) -> None:
    seen = 0

    def thin(message: dict[str, object]) -> dict[str, object] | None:
        nonlocal seen
        seen += 1
        return None if seen % 20 == 0 else message

    one = replayed(changed(tmp_path / "p1.mcap", change={"/obstacles": thin}))
    assert one.skipped > 2
    assert "lack their obstacles" in one.text()


def test_a_recording_that_is_cut_off_is_decided_up_to_the_cut(tmp_path: Path) -> None:
    source = fresh_pieces(tmp_path)
    data = source.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 3 // 4])
    one = replayed(cut, tolerance=TOLERANCE)
    assert not one.complete
    assert 0 < one.decisions < replayed(source).decisions
    assert one.identical
    assert "cut off" in one.text()


def fresh_pieces(folder: Path) -> Path:
    """The golden pursuer in many small chunks, as a recorder in flight leaves them."""
    return changed(folder / "p1.mcap", chunk_size=16384)


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (lambda path: changed(path, profile="ros2"), r"not a recording of this application"),
        (lambda path: changed(path, run={"flightapp": "7.0.0"}), r"recorded by flightapp 7\.0\.0; this is 0\."),
        (lambda path: changed(path, without=("/observation",)), r"has no /observation channel"),
        (lambda path: changed(path, without=("/observation", "/setpoint")), r"nothing was decided in this recording"),
        (lambda path: changed(path, without=("profile.toml",)), r"profile\.toml is not attached"),
        (lambda path: changed(path, run={"vehicle": "p9"}), r"is of 'p9', which the attached mission does not have"),
        (lambda path: changed(path, run={"seed": "many"}), r"seed = 'many': must be a whole number"),
        (
            lambda path: changed(path, change={"/observation": lambda message: {**message, "team": 3}}),
            r"/observation, message 1: .*team",
        ),
    ],
)
def test_bad_input_is_one_sentence(tmp_path: Path, build: object, sentence: str) -> None:
    path = tmp_path / "p1.mcap"
    build(path)  # type: ignore[operator]
    with pytest.raises(InputError, match=sentence) as error:
        replay(Wanted(path))
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)


def test_a_run_folder_is_decided_vehicle_by_vehicle(tmp_path: Path) -> None:
    for name, vehicle in (("demo_pursuer", "p1"), ("demo_evader", "e1")):
        shutil.copy(GOLDEN / f"{name}.mcap", tmp_path / f"{vehicle}.mcap")
    (tmp_path / "p2.mcap").write_bytes(b"not a recording")
    (tmp_path / "p1.small.mcap").write_bytes(b"not to be looked at")
    both = replay(Wanted(tmp_path, tolerance=TOLERANCE))
    assert [one.vehicle for one in both.replayed] == ["e1", "p1"]
    assert both.identical
    assert [path.name for path, _ in both.left_out] == ["p2.mcap"]
    assert "p2.mcap: not a recording" in both.text()
    [only] = replay(Wanted(tmp_path, vehicle="e1")).replayed
    assert only.vehicle == "e1"
    other = replay(Wanted(tmp_path, planner="apf"))
    assert [one.vehicle for one in other.replayed] == ["p1"]
    assert any("'apf' is not for the evader e1" in reason for _, reason in other.left_out)
    with pytest.raises(InputError, match="no such planner"):
        replay(Wanted(tmp_path, planner="magic"))


def test_the_command_line_tells_it_with_its_exit_status(tmp_path: Path) -> None:
    runner = CliRunner()
    same = runner.invoke(cli.app, ["replay", str(PURSUER), "--tolerance", str(TOLERANCE), "--json"])
    assert same.exit_code == 0
    [vehicle] = json.loads(same.stdout)["vehicles"]
    assert vehicle["identical"] is True
    out = tmp_path / "differences.json"
    other = runner.invoke(cli.app, ["replay", str(PURSUER), "--planner", "geo-apf", "--out", str(out)])
    assert other.exit_code == 1
    assert re.search(r"\d+ of \d+ decisions differ, first after", other.stdout)
    [written] = json.loads(out.read_text())["vehicles"]
    assert len(written["differences"]) >= written["decisions_differ"] > 0
    assert written["differences"][0]["t_s"] > 0.0
