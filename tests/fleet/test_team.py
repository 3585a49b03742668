"""The fleet over real Zenoh sessions on loopback UDP."""

import asyncio
import time
from collections.abc import Callable, Iterator

import pytest
import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.messages.codec import Header, encode
from flightapp.fleet.messages.command import Command
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.keys import command_key, key
from flightapp.fleet.messages.state import STATE, State
from flightapp.fleet.operator import Operator
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team
from flightapp.sim.fleet_files import ReservedPorts


def own_state(t_s: float) -> State:
    return State(t_s, (1.0, 2.0, -5.0), (0.0, 0.0, 0.0), 0.0, airborne=True, phase="pursue", outcome=None)


def own_intent(mode: str = "coarse") -> Intent:
    return Intent("pursuer", "0123456789ab", 1, mode, None, None, None, None, None, ())


def until(condition: Callable[[], bool], timeout_s: float = 10.0) -> None:
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, "condition not met in time"
        time.sleep(0.005)


@pytest.fixture
def endpoints() -> Iterator[list[str]]:
    ports = ReservedPorts(2)
    yield [f"udp/127.0.0.1:{port}" for port in ports.numbers]
    ports.release()


@pytest.fixture
def sessions(endpoints: list[str]) -> Iterator[list[zenoh.Session]]:
    first = zenoh.open(zenoh_config([endpoints[0]], [endpoints[1]]))
    second = zenoh.open(zenoh_config([endpoints[1]], [endpoints[0]]))
    yield [first, second]
    first.close()
    second.close()


def test_two_vehicles_hear_each_other_and_the_newest_state_wins(sessions: list[zenoh.Session]) -> None:
    complaints: list[str] = []
    clock = SystemClock()
    p1 = Team(sessions[0], "f", "p1", ["p2"], lambda _, text: complaints.append(text))
    p2 = Team(sessions[1], "f", "p2", ["p1"], lambda _, text: complaints.append(text))

    def heard() -> bool:
        p1.publish(own_state(clock.now_s()), own_intent(), clock.now_s())
        p2.poll(clock.now_s())
        return p2.peers["p1"].state is not None

    until(heard)

    def newest() -> bool:
        p1.publish(own_state(clock.now_s()), own_intent("fine"), clock.now_s())
        p2.poll(clock.now_s())
        state = p2.peers["p1"].state
        return state is not None and state.mode == "fine"

    until(newest)
    assert complaints == []


def test_a_state_under_a_foreign_key_is_refused_and_reported(sessions: list[zenoh.Session]) -> None:
    complaints: list[str] = []
    p2 = Team(sessions[1], "f", "p2", ["p1"], lambda peer, text: complaints.append(f"{peer}: {text}"))
    impostor = sessions[0].declare_publisher(key("f", "p1", "state"))

    def complained() -> bool:
        impostor.put(encode(STATE, own_state(time.time()), Header("p9", 1, time.time())))
        p2.poll(time.time())
        return bool(complaints)

    until(complained)
    assert "claims to be from 'p9'" in complaints[0]
    assert p2.peers["p1"].state is None


def test_a_command_is_acknowledged_once_obeyed_once_and_refused_when_old(sessions: list[zenoh.Session]) -> None:
    clock = SystemClock()
    obeyed: list[Command] = []
    judged: list[tuple[str, bool]] = []
    team = Team(sessions[0], "f", "p1", [], lambda *_: None)
    operator = Operator(sessions[1], "f", clock)

    def accept(command: Command) -> tuple[bool, str]:
        obeyed.append(command)
        return True, "landing"

    async def ask(command: Command) -> tuple[bool, str]:
        asking = asyncio.create_task(operator.send(command, ["p1"], 10.0))
        while not asking.done():
            judged.extend((one.identifier, answer.accepted) for one, answer in team.take_commands(clock.now_s(), accept))
            await asyncio.sleep(0.005)
        (answer,) = asking.result()
        return answer.accepted, answer.text

    async def story() -> None:
        command = Command("land", "1", clock.now_s(), "ann")
        assert await ask(command) == (True, "landing")
        assert await ask(command) == (True, "landing")
        assert len(obeyed) == 1
        for action, age_s, words in (("resume", 60.0, "60.0 s old"), ("hold", -60.0, "60.0 s in the future")):
            accepted, text = await ask(Command(action, action, clock.now_s() - age_s, "ann"))
            assert not accepted
            assert words in text
        assert len(obeyed) == 1
        for action in ("land", "abort", "rtl"):
            wrong_clock = Command(action, f"late {action}", clock.now_s() - 60.0, "ann with a wrong clock")
            assert await ask(wrong_clock) == (True, "landing")
        refused = [("resume", False), ("hold", False)]
        assert judged == [("1", True), *refused, ("late land", True), ("late abort", True), ("late rtl", True)]

    asyncio.run(story())


def test_a_command_that_cannot_be_read_is_answered_with_the_reason(sessions: list[zenoh.Session]) -> None:
    complaints: list[str] = []
    team = Team(sessions[0], "f", "p1", [], lambda _, text: complaints.append(text))
    said: list[str] = []

    def answered() -> bool:
        replies = sessions[1].get(command_key("f", "p1"), payload=bytes((9, 0)), timeout=1.0)
        team.take_commands(time.time(), lambda _: (True, "never"))
        time.sleep(0.02)
        team.take_commands(time.time(), lambda _: (True, "never"))
        said.extend(reply.err.payload.to_bytes().decode() for reply in replies if reply.err is not None)
        return any("version 9.0" in text for text in said)

    until(answered)
    assert "this software speaks version 2" in complaints[0]
