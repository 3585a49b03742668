"""The fleet over real Zenoh sessions on loopback UDP."""

import asyncio
import time
from collections.abc import Callable, Iterator

import pytest
import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.messages import Command, SharedState, command_key, encode_state, state_key
from flightapp.fleet.operator import Operator
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Peer, Team
from flightapp.sim.fleet_files import ReservedPorts


def shared_state(name: str, sequence: int, sent_s: float, **changes: object) -> SharedState:
    values: dict[str, object] = {
        "vehicle": name,
        "role": "pursuer",
        "sequence": sequence,
        "sent_s": sent_s,
        "t_s": sent_s,
        "position_ned_m": (1.0, 2.0, -5.0),
        "velocity_ned_m_s": (0.0, 0.0, 0.0),
        "yaw_rad": 0.0,
        "airborne": True,
        "phase": "pursue",
        "mode": "coarse",
        "outcome": None,
        "eta_s": None,
        "target_distance_m": None,
        "clearance_m": None,
        "link_age_s": None,
        "mission": "0123456789ab",
    }
    return SharedState(**(values | changes))  # type: ignore[arg-type]


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
        p1.publish(shared_state("p1", p1.next_sequence(), clock.now_s()))
        p2.poll(clock.now_s())
        return p2.peers["p1"].state is not None

    until(heard)
    last = p1.next_sequence()
    p1.publish(shared_state("p1", last, clock.now_s(), mode="fine"))

    def newest() -> bool:
        p2.poll(clock.now_s())
        state = p2.peers["p1"].state
        return state is not None and state.sequence == last

    until(newest)
    assert p2.peers["p1"].state is not None
    assert p2.peers["p1"].state.mode == "fine"
    assert complaints == []


def test_a_state_under_a_foreign_key_is_refused_and_reported(sessions: list[zenoh.Session]) -> None:
    complaints: list[str] = []
    p2 = Team(sessions[1], "f", "p2", ["p1"], lambda peer, text: complaints.append(f"{peer}: {text}"))
    impostor = sessions[0].declare_publisher(state_key("f", "p1"))

    def complained() -> bool:
        impostor.put(encode_state(shared_state("p9", 1, time.time())))
        p2.poll(time.time())
        return bool(complaints)

    until(complained)
    assert "claims to be 'p9'" in complaints[0]
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
        replies = sessions[1].get(command_key("f", "p1"), payload=b'{"version": 9}', timeout=1.0)
        team.take_commands(time.time(), lambda _: (True, "never"))
        time.sleep(0.02)
        team.take_commands(time.time(), lambda _: (True, "never"))
        said.extend(reply.err.payload.to_bytes().decode() for reply in replies if reply.err is not None)
        return any("version 9" in text for text in said)

    until(answered)
    assert "this software speaks version 1" in complaints[0]


def test_late_repeated_and_future_states_are_not_taken() -> None:
    peer = Peer()
    assert peer.accept(shared_state("p1", 5, 100.0), 100.0)
    assert not peer.accept(shared_state("p1", 5, 100.0), 100.0)
    assert not peer.accept(shared_state("p1", 4, 99.9), 100.0)
    assert not peer.accept(shared_state("p1", 6, 101.0), 100.05)
    assert peer.accept(shared_state("p1", 9, 100.2), 100.2)
    assert peer.lost == 3
    assert peer.rejected == 3


def test_a_restarted_vehicle_counts_from_one_again_and_is_heard() -> None:
    peer = Peer()
    assert peer.accept(shared_state("p1", 500, 100.0), 100.0)
    assert peer.accept(shared_state("p1", 1, 103.0), 103.0)
    assert peer.lost == 0
