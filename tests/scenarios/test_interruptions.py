"""What happens when a person, or the machine, ends things early."""

import json
import signal
import subprocess
import sys
from pathlib import Path

from flightapp.recording.reader import read_recording
from flightapp.recording.recover import recover
from tests.runtime.one_vehicle import until
from tests.scenarios.simulation import HOVER, ROOT, simulation

VEHICLES = ("p1", "p2", "e1")


def test_ctrl_c_in_full_chase_lands_every_vehicle_and_leaves_nothing(tmp_path: Path) -> None:
    with simulation(tmp_path) as demo:
        demo.until(lambda: all(demo.phase(name) == "pursue" for name in VEHICLES), 60.0, "pursuit")
        demo.until(lambda: demo.said().count("coarse") > 6, 20.0, "progress")
        demo.interrupt()
        assert demo.process.wait(timeout=90) == 1
        assert demo.processes() == []
        assert demo.summary()["outcome"] == "aborted"
        assert demo.summary()["min_obstacle_clearance_m"] > 0.0
        truth = read_recording(demo.run / "truth.mcap").topic("/truth").messages
        for name in VEHICLES:
            last = [message for message in truth if message["vehicle"] == name][-1]
            assert last["on_ground"]
            assert not last["armed"]
            assert read_recording(demo.run / f"{name}.mcap").complete


def test_a_second_ctrl_c_ends_everything_at_once(tmp_path: Path) -> None:
    with simulation(tmp_path, HOVER) as hover:
        hover.until(lambda: hover.phase("e1") == "pursue", 60.0, "flight")
        hover.interrupt()
        hover.until(lambda: "press Ctrl-C again" in hover.said(), 5.0, "answer to Ctrl-C")
        hover.interrupt()
        assert hover.process.wait(timeout=20) == 3
        assert hover.processes() == []


def test_a_vehicle_process_killed_in_the_chase_is_told_and_its_recording_survives(tmp_path: Path) -> None:
    with simulation(tmp_path) as demo:
        demo.until(lambda: all(demo.phase(name) == "pursue" for name in VEHICLES), 60.0, "pursuit")
        demo.vehicle_process("p1").kill()
        demo.until(lambda: "p1: ended with status 3" in demo.said(), 10.0, "word of the death")
        demo.interrupt()
        assert demo.process.wait(timeout=90) == 3
        assert demo.processes() == []
        cut = read_recording(demo.run / "p1.mcap")
        assert not cut.complete
        recover(demo.run / "p1.mcap", demo.run / "p1-recovered.mcap")
        assert read_recording(demo.run / "p1-recovered.mcap").complete
        log = (demo.run / "p1-autopilot.jsonl").read_text()
        assert '"mode": "LAND"' in log


def test_when_the_launcher_is_killed_no_process_stays(tmp_path: Path) -> None:
    with simulation(tmp_path, HOVER) as hover:
        hover.until(lambda: hover.phase("e1") == "pursue", 60.0, "flight")
        left = hover.processes()
        hover.process.send_signal(signal.SIGKILL)
        hover.process.wait()
        assert left
        until(lambda: hover.processes() == [], 60.0, "end of all processes")


def test_two_runs_side_by_side_do_not_meet(tmp_path: Path) -> None:
    mission = tmp_path / "short.toml"
    mission.write_text(HOVER.read_text().replace("time_limit_s = 60.0", "time_limit_s = 4.0"))
    with simulation(tmp_path / "a", mission) as first, simulation(tmp_path / "b", mission) as second:
        assert first.process.wait(timeout=120) == 1, first.said()
        assert second.process.wait(timeout=120) == 1, second.said()
        for run in (first, second):
            assert run.summary()["outcome"] == "timeout"
            assert read_recording(run.run / "e1.mcap").complete


def test_an_operator_lands_the_fleet_from_another_terminal(tmp_path: Path) -> None:
    with simulation(tmp_path, HOVER) as hover:
        hover.until(lambda: hover.phase("e1") == "pursue", 60.0, "flight")
        profile = (hover.run / "profile-e1.toml").read_text()
        endpoint = next(part for part in profile.split('"') if part.startswith("udp/127.0.0.1:"))
        command = [sys.executable, "-m", "flightapp", "command", "land", str(HOVER), "--connect", endpoint]
        command += ["--record", str(tmp_path / "commands.jsonl")]
        said = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=30, check=False)
        assert said.returncode == 0, said.stderr
        assert said.stdout.startswith("e1: accepted, landing (")
        assert hover.process.wait(timeout=60) == 1
        assert hover.summary()["outcome"] == "aborted"
        (asked,) = [json.loads(line) for line in (tmp_path / "commands.jsonl").read_text().splitlines()]
        events = read_recording(hover.run / "e1.mcap").topic("/event").messages
        (obeyed,) = [event["data"] for event in events if event["name"] == "command"]
        assert obeyed["identifier"] == asked["identifier"]
        assert obeyed["operator"] == f"{asked['user']}@{asked['host']}"
        assert obeyed["accepted"] is True
