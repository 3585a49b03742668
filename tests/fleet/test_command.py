"""`flightapp command` against vehicles in processes of their own: quick, honest about who does not answer, on record."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.config.mission import Mission, load_mission
from flightapp.core.clock import SystemClock
from flightapp.core.errors import InputError
from flightapp.fleet.audit import operator_name
from flightapp.fleet.command import Wish, new_command, send_command
from flightapp.fleet.messages.command import Command
from flightapp.fleet.operator import ASK_AGAIN_S, Answer, Operator
from flightapp.fleet.session import open_session
from flightapp.sim.fleet_files import ReservedPorts

ROOT = Path(__file__).parents[2]
MISSION_FILE = ROOT / "missions/demo_two_pursuers.toml"
NAMES = ("p1", "p2", "e1")
QUICK_S = 0.2


@dataclass
class Fleet:
    """Three vehicle processes of the fleet `hover` and the files of what they obeyed."""

    folder: Path
    endpoints: list[str]
    processes: dict[str, subprocess.Popen[str]]
    mission: Mission

    def obeyed(self, name: str) -> list[str]:
        file = self.folder / f"{name}.obeyed"
        return file.read_text().splitlines() if file.exists() else []

    def send(self, action: str, timeout_s: float = 3.0, vehicle: str | None = None) -> list[Answer]:
        wish = Wish(action, vehicle, self.endpoints, timeout_s, self.folder / "commands.jsonl")
        return asyncio.run(send_command(self.mission, wish, lambda _: None))

    def records(self) -> list[dict[str, object]]:
        return [json.loads(line) for line in (self.folder / "commands.jsonl").read_text().splitlines()]


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Fleet]:
    ports = ReservedPorts(len(NAMES))
    endpoints = [f"udp/127.0.0.1:{port}" for port in ports.numbers]
    processes = {
        name: subprocess.Popen(
            [sys.executable, "-m", "tests.fleet.answering_vehicle", name, endpoint, str(tmp_path / f"{name}.obeyed")],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        for name, endpoint in zip(NAMES, endpoints, strict=True)
    }
    try:
        for process in processes.values():
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
        mission = load_mission(MISSION_FILE).model_copy(update={"fleet": "hover"})
        yield Fleet(tmp_path, endpoints, processes, mission)
    finally:
        for process in processes.values():
            process.kill()
            process.wait()
            if process.stdout is not None:
                process.stdout.close()
        ports.release()


def test_a_frozen_and_a_dead_vehicle_delay_nobody_and_are_named(fleet: Fleet) -> None:
    for action in ("hold", "rtl", "land", "abort"):
        answers = fleet.send(action)
        assert {answer.vehicle for answer in answers if answer.accepted} == set(NAMES)
        assert max(answer.round_trip_s or 9.0 for answer in answers) < QUICK_S
    os.kill(fleet.processes["p1"].pid, signal.SIGSTOP)
    try:
        p2, e1, p1 = fleet.send("hold", timeout_s=1.0)
        assert {p2.vehicle, e1.vehicle} == {"p2", "e1"}
        assert p2.round_trip_s is not None
        assert e1.round_trip_s is not None
        assert max(p2.round_trip_s, e1.round_trip_s) < QUICK_S
        assert (p1.vehicle, p1.accepted, p1.round_trip_s) == ("p1", False, None)
        assert "no answer within 1 s" in p1.text
    finally:
        os.kill(fleet.processes["p1"].pid, signal.SIGCONT)
    fleet.processes["p2"].kill()
    *alive, dead = fleet.send("land", timeout_s=1.0)
    assert {answer.vehicle for answer in alive if answer.accepted} == {"p1", "e1"}
    assert dead.vehicle == "p2"
    assert not dead.accepted


def test_asked_several_times_it_is_obeyed_once_and_a_new_wish_once_more(fleet: Fleet) -> None:
    clock = SystemClock()

    async def ask(command: Command, times: int) -> list[Answer]:
        session = await open_session([], fleet.endpoints[:1], wait_for_peers=False)
        try:
            operator = Operator(session, "hover", clock)
            return [answer for _ in range(times) for answer in await operator.send(command, ["p1"], 3.0)]
        finally:
            await asyncio.to_thread(session.close)

    first = new_command("hold", clock)
    answers = asyncio.run(ask(first, 3))
    assert [(answer.accepted, answer.text) for answer in answers] == [(True, "obeys hold")] * 3
    assert fleet.obeyed("p1") == [f"hold {first.identifier} {operator_name()}"]
    again = new_command("hold", clock)
    assert again.identifier != first.identifier
    asyncio.run(ask(again, 1))
    assert len(fleet.obeyed("p1")) == 2


def test_a_vehicle_that_was_frozen_obeys_once_however_often_it_was_asked_meanwhile(fleet: Fleet) -> None:
    clock = SystemClock()
    land = new_command("land", clock)

    async def story() -> None:
        session = await open_session([], fleet.endpoints[:1], wait_for_peers=False)
        try:
            operator = Operator(session, "hover", clock)
            (connected,) = await operator.send(new_command("hold", clock), ["p1"], 3.0)
            assert connected.accepted
            os.kill(fleet.processes["p1"].pid, signal.SIGSTOP)
            try:
                (silent,) = await operator.send(land, ["p1"], 4 * ASK_AGAIN_S)
            finally:
                os.kill(fleet.processes["p1"].pid, signal.SIGCONT)
            assert silent.round_trip_s is None
            (late,) = await operator.send(land, ["p1"], 3.0)
            assert late.accepted
        finally:
            await asyncio.to_thread(session.close)

    asyncio.run(story())
    assert fleet.obeyed("p1")[1:] == [f"land {land.identifier} {operator_name()}"]


def test_the_terminal_shows_every_answer_its_time_and_why_not_and_the_record_keeps_it(fleet: Fleet) -> None:
    mission = fleet.folder / "mission.toml"
    mission.write_text(MISSION_FILE.read_text().replace(f'fleet = "{load_mission(MISSION_FILE).fleet}"', 'fleet = "hover"'))
    connect = [part for endpoint in fleet.endpoints for part in ("--connect", endpoint)]
    record = ["--record", str(fleet.folder / "commands.jsonl")]
    said = CliRunner().invoke(app, ["command", "resume", str(mission), *connect, *record])
    assert said.exit_code == 3
    for name in NAMES:
        (line,) = [line for line in said.output.splitlines() if line.startswith(f"{name}: ")]
        assert line.startswith(f"{name}: REFUSED, not possible in phase takeoff (")
        assert line.endswith(" ms)")
    said = CliRunner().invoke(app, ["command", "hold", str(mission), *connect, *record, "--json"])
    assert said.exit_code == 0
    told = json.loads(said.output)
    assert {one["vehicle"] for one in told} == set(NAMES)
    assert all(one["accepted"] and 0.0 < one["round_trip_ms"] < 1e3 * QUICK_S for one in told)
    resume, hold = fleet.records()
    assert resume["action"] == "resume"
    assert f"{resume['user']}@{resume['host']}" == operator_name()
    assert hold["vehicles"] == list(NAMES)
    assert hold["answers"] == told
    assert [line.split()[1] for line in fleet.obeyed("p1")] == [resume["identifier"], hold["identifier"]]


def test_without_any_vehicle_everyone_is_missing_after_the_timeout_and_that_is_recorded_too(tmp_path: Path) -> None:
    blocked = tmp_path / "a-file"
    blocked.write_text("")
    began_s = time.monotonic()
    arguments = ["command", "land", str(MISSION_FILE), "--connect", "udp/127.0.0.1:9", "--timeout", "0.5", "--record"]
    said = CliRunner().invoke(app, [*arguments, str(tmp_path / "commands.jsonl")])
    assert said.exit_code == 3
    assert said.output.count("NO ANSWER") == len(NAMES)
    assert time.monotonic() - began_s < 2.0
    (record,) = [json.loads(line) for line in (tmp_path / "commands.jsonl").read_text().splitlines()]
    assert [answer["round_trip_ms"] for answer in record["answers"]] == [None] * len(NAMES)
    said = CliRunner().invoke(app, [*arguments, str(blocked / "commands.jsonl")])
    assert said.exit_code == 3, "a record that cannot be written does not keep the command from being sent"
    assert "not recorded" in said.output


def test_what_cannot_be_sent_is_said_before_anything_is(tmp_path: Path) -> None:
    mission = load_mission(MISSION_FILE)
    for action, vehicle, endpoint, words in (
        ("dance", None, "udp/127.0.0.1:9", "hold, resume, rtl, land, abort"),
        ("land", "p9", "udp/127.0.0.1:9", "known: p1, p2, e1"),
        ("land", None, "nonsense", "udp/HOST:PORT"),
    ):
        wish = Wish(action, vehicle, [endpoint], 1.0, tmp_path / "commands.jsonl")
        with pytest.raises(InputError, match=words):
            asyncio.run(send_command(mission, wish, lambda _: None))
    assert not (tmp_path / "commands.jsonl").exists()
