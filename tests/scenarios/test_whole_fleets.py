"""Several vehicles, or several runs, and a person who ends them: everybody comes down, and nobody else is meant."""

import json
import subprocess
import sys
from pathlib import Path

from flightapp.recording.reader import Recording, read_recording
from flightapp.recording.recover import recover
from tests.scenarios.simulation import HOVER, ROOT, Simulation, simulation

VEHICLES = ("p1", "p2", "e1")


def assert_landed(run: Path, name: str) -> None:
    """On the ground, disarmed, and recorded to the end."""
    truth = read_recording(run / "truth.mcap").topic("/truth").messages
    last = [message for message in truth if message["vehicle"] == name][-1]
    assert last["on_ground"]
    assert not last["armed"]
    assert read_recording(run / f"{name}.mcap").complete


def test_one_is_killed_in_full_chase_and_ctrl_c_lands_the_others_and_leaves_nothing(tmp_path: Path) -> None:
    with simulation(tmp_path) as demo:
        demo.until(lambda: all(demo.phase(name) == "pursue" for name in VEHICLES), 60.0, "pursuit")
        demo.until(lambda: demo.said().count("coarse") > 6, 20.0, "progress")
        demo.vehicle_process("p1").kill()
        demo.until(lambda: "p1: ended with status 3" in demo.said(), 10.0, "word of the death")
        demo.interrupt()
        assert demo.process.wait(timeout=90) == 3
        assert demo.processes() == []
        for name in ("p2", "e1"):
            assert_landed(demo.run, name)
            assert demo.summary()["vehicles"][name]["outcome"] == "aborted"
            assert demo.summary()["vehicles"][name]["min_obstacle_clearance_m"] > 0.0
        assert not read_recording(demo.run / "p1.mcap").complete
        recover(demo.run / "p1.mcap", demo.run / "p1-recovered.mcap")
        assert read_recording(demo.run / "p1-recovered.mcap").complete
        assert '"mode": "LAND"' in (demo.run / "p1-autopilot.jsonl").read_text()


def test_of_two_runs_side_by_side_each_is_landed_alone_by_an_operator_and_by_ctrl_c(tmp_path: Path) -> None:
    """The same fleet and vehicle names on the same machine: what one run is told does not reach the other."""
    with simulation(tmp_path / "a", HOVER) as first, simulation(tmp_path / "b", HOVER) as second:
        for run in (first, second):
            run.until(lambda run=run: run.phase("e1") == "pursue", 60.0, "flight")
        record = tmp_path / "commands.jsonl"
        said = land_from_another_terminal(first, record)
        assert said.returncode == 0, said.stderr
        assert said.stdout.startswith("e1: accepted, landing (")
        assert first.process.wait(timeout=60) == 1
        assert first.summary()["outcome"] == "aborted"
        (asked,) = [json.loads(line) for line in record.read_text().splitlines()]
        (obeyed,) = commands_of(read_recording(first.run / "e1.mcap"))
        assert obeyed["identifier"] == asked["identifier"]
        assert obeyed["operator"] == f"{asked['user']}@{asked['host']}"
        assert obeyed["accepted"] is True

        assert second.phase("e1") == "pursue", "it was not asked"
        second.interrupt()
        assert second.process.wait(timeout=90) == 1
        assert second.processes() == []
        assert second.summary()["outcome"] == "aborted"
        (other,) = commands_of(read_recording(second.run / "e1.mcap"))
        assert other["identifier"] != asked["identifier"]
        for run in (first, second):
            assert_landed(run.run, "e1")


def land_from_another_terminal(hover: Simulation, record: Path) -> subprocess.CompletedProcess[str]:
    profile = (hover.run / "profile-e1.toml").read_text()
    endpoint = next(part for part in profile.split('"') if part.startswith("udp/127.0.0.1:"))
    command = [sys.executable, "-m", "flightapp", "command", "land", str(HOVER), "--connect", endpoint, "--record", str(record)]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=30, check=False)


def commands_of(recording: Recording) -> list[dict[str, object]]:
    return [event["data"] for event in recording.topic("/event").messages if event["name"] == "command"]
