"""A fleet with certificates, and everybody who should not be heard in it: real Zenoh sessions on loopback."""

from __future__ import annotations

import json
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import zenoh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flightapp.fleet.messages.codec import Header, encode
from flightapp.fleet.messages.command import Command, encode_command
from flightapp.fleet.messages.intent import INTENT
from flightapp.fleet.messages.keys import ALIVE, CLOCK, COMMAND, key
from flightapp.fleet.messages.state import STATE
from flightapp.fleet.session import MESSAGE_MAX_BYTES
from tests.fleet.security.members import FLEET, Loopback, Vehicle, make_fleet_keys, own_intent, own_state, until

ROOT = Path(__file__).parents[3]
STATE_OF_P1 = key(FLEET, "p1", "state")


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_fleet_keys(tmp_path_factory.mktemp("fleet") / "keys")


@pytest.fixture
def loopback(keys: Path) -> Iterator[Loopback]:
    fleet = Loopback(keys)
    yield fleet
    fleet.close()


@pytest.fixture
def pair(loopback: Loopback) -> tuple[Vehicle, Vehicle]:
    """p1 and e1 fly and hear each other."""
    first, second = loopback.endpoint(0), loopback.endpoint(1)
    p1, e1 = Vehicle("p1", loopback.member("p1", [first], [second])), Vehicle("e1", loopback.member("e1", [second], [first]))
    both_fly_on(p1, e1)
    return p1, e1


def both_fly_on(p1: Vehicle, e1: Vehicle) -> None:
    """From now on each hears something new of the other."""
    since_s = time.time()
    until(lambda: p1.hears("e1", since_s + p1.clock_ahead_s) & e1.hears("p1", since_s))


def ask(session: zenoh.Session, selector: str, payload: bytes, victim: Vehicle) -> list[str]:
    """What a question brings while the victim flies; '!' before an error of the other side."""
    replies = session.get(selector, payload=payload, timeout=0.5, target=zenoh.QueryTarget.ALL)
    deadline = time.monotonic() + 0.6
    said = []
    while time.monotonic() < deadline:
        victim.tick()
        try:
            reply = replies.try_recv()
        except zenoh.ZError:
            break
        if reply is None:
            time.sleep(0.005)
        elif reply.ok is not None:
            said.append(str(reply.ok.key_expr))
        elif reply.err.payload.to_bytes() != b"Timeout":
            said.append("!" + reply.err.payload.to_bytes().decode())
    return said


def test_members_hear_each_other_and_the_operators_command_is_obeyed(loopback: Loopback, pair: tuple[Vehicle, Vehicle]) -> None:
    p1, e1 = pair
    operator = loopback.member("operator", [], [loopback.endpoint(0)])
    until(lambda: bool(ask(operator, key(FLEET, "p1", COMMAND), command("hold"), p1)))
    assert p1.obeyed == ["hold"]
    assert (p1.complaints, e1.complaints) == ([], [])


def command(action: str, age_s: float = 0.0) -> bytes:
    return encode_command(Command(action, f"{action} of {age_s} s", time.time() - age_s, "ann@tower"))


def test_a_member_that_writes_the_keys_of_another_is_not_heard_whatever_it_tries(
    loopback: Loopback, pair: tuple[Vehicle, Vehicle]
) -> None:
    p1, e1 = pair
    liar = loopback.member("p2", [], [loopback.endpoint(1)], obeys_rules=False)
    alive = e1.session.liveliness().declare_subscriber(key(FLEET, "*", ALIVE), zenoh.handlers.RingChannel(64), history=True)
    tokens = [liar.liveliness().declare_token(key(FLEET, name, ALIVE)) for name in ("p1", "p2")]
    lies = [
        liar.declare_publisher(expression, reliability=reliability)
        for reliability in (zenoh.Reliability.RELIABLE, zenoh.Reliability.BEST_EFFORT)
        for expression in (STATE_OF_P1, f"flightapp/{FLEET}/*/state", f"flightapp/{FLEET}/**", "**")
    ]
    own_words = [liar.declare_publisher(key(FLEET, "p2", kind)) for kind in ("state", "intent")]
    far_away = replace(own_state(time.time()), position_ned_m=(999.0, 0.0, -5.0))
    sequence = 1_000_000
    positions = set()

    def tell_lies_and_the_truth() -> bool:
        nonlocal sequence
        sequence += 1
        now_s = time.time()
        for publisher in lies:
            publisher.put(encode(STATE, far_away, Header("p1", sequence, now_s)))
            publisher.delete()
        for publisher, kind, message in zip(own_words, (STATE, INTENT), (own_state(now_s), own_intent()), strict=True):
            publisher.put(encode(kind, message, Header("p2", sequence, now_s)))
        p1.tick()
        heard = e1.hears("p2", 0.0)
        state = e1.team.peers["p1"].state
        assert state is not None
        positions.add(state.position_ned_m)
        return heard

    until(tell_lies_and_the_truth)
    for _ in range(20):
        tell_lies_and_the_truth()
    assert positions == {own_state(0.0).position_ned_m}, "what p2 said in p1's name was taken"
    both_fly_on(p1, e1)
    living = [str(sample.key_expr) for sample in iter(alive.try_recv, None)]
    assert key(FLEET, "p2", ALIVE) in living, "p2's own token proves that its link is up"
    assert key(FLEET, "p1", ALIVE) not in living
    del tokens


def test_a_member_cannot_command_nor_answer_for_another_but_may_ask_the_time(
    loopback: Loopback, pair: tuple[Vehicle, Vehicle]
) -> None:
    p1, e1 = pair
    clock = p1.session.declare_queryable(key(FLEET, "p1", CLOCK), lambda query: query.reply(query.key_expr, b"12"))
    liar = loopback.member("p2", [], [loopback.endpoint(0)], obeys_rules=False)
    until(lambda: ask(liar, key(FLEET, "p1", CLOCK), b"", p1) == [key(FLEET, "p1", CLOCK)])
    for selector in (key(FLEET, "p1", COMMAND), f"flightapp/{FLEET}/*/command", f"flightapp/{FLEET}/**", "**"):
        assert ask(liar, selector, command("land"), p1) == [], selector
    assert p1.obeyed == []
    operator = loopback.member("operator", [loopback.endpoint(2)], [loopback.endpoint(0)])
    second_liar = loopback.member("p2", [], [loopback.endpoint(2)], obeys_rules=False)
    fooled = second_liar.declare_queryable(key(FLEET, "e1", COMMAND), lambda query: query.reply(query.key_expr, b"done"))
    until(lambda: ask(operator, key(FLEET, "p1", COMMAND), command("rtl"), p1) == [key(FLEET, "p1", COMMAND)])
    assert ask(operator, key(FLEET, "e1", COMMAND), command("rtl"), p1) == [], "an answer in e1's name came from p2"
    both_fly_on(p1, e1)
    del clock, fooled


@pytest.mark.parametrize("stranger", ["other authority", "expired", "not yet valid", "udp", "tcp"])
def test_who_is_no_member_hears_nothing_and_is_not_heard(
    loopback: Loopback, pair: tuple[Vehicle, Vehicle], tmp_path: Path, stranger: str
) -> None:
    p1, e1 = pair
    if stranger in ("udp", "tcp"):
        session = loopback.plain([loopback.endpoint(0, stranger)])
    else:
        begin_s = {"other authority": 0.0, "expired": -2 * 86400.0, "not yet valid": 2 * 86400.0}[stranger]
        foreign = make_fleet_keys(tmp_path / "keys", time.time() + begin_s)
        session = loopback.with_certificates_of(foreign, "operator", [loopback.endpoint(0)])
    heard = session.declare_subscriber("**", zenoh.handlers.RingChannel(64), allowed_origin=zenoh.Locality.REMOTE)
    publisher = session.declare_publisher(key(FLEET, "e1", "state"))
    deadline = time.monotonic() + 0.6
    while time.monotonic() < deadline:
        publisher.put(b"nonsense")
        both_fly_on(p1, e1)
    assert ask(session, key(FLEET, "p1", COMMAND), command("land"), p1) == []
    assert heard.try_recv() is None
    assert list(session.info.peers_zid()) == []
    assert (p1.obeyed, p1.complaints) == ([], [])


def test_an_expired_authority_keeps_its_own_members_out_too(tmp_path: Path) -> None:
    fleet = Loopback(make_fleet_keys(tmp_path / "keys", time.time() - 2 * 86400.0))
    try:
        first = fleet.member("p1", [fleet.endpoint(0)], [])
        second = fleet.member("p2", [], [fleet.endpoint(0)])
        time.sleep(0.5)
        assert list(first.info.peers_zid()) == list(second.info.peers_zid()) == []
    finally:
        fleet.close()


def test_recorded_commands_that_are_sent_again_change_nothing(loopback: Loopback, pair: tuple[Vehicle, Vehicle]) -> None:
    p1, _ = pair
    operator = loopback.member("operator", [], [loopback.endpoint(0)])
    thief = loopback.member("p2", [], [loopback.endpoint(0)], obeys_rules=False)
    place = key(FLEET, "p1", COMMAND)
    recorded = {action: command(action) for action in ("hold", "land")}
    for payload in recorded.values():
        until(lambda payload=payload: bool(ask(operator, place, payload, p1)))  # type: ignore[misc]
    assert p1.obeyed == ["hold", "land"]
    p1.clock_ahead_s = 6.0
    for payload in recorded.values():
        assert ask(operator, place, payload, p1) == [place], "known identifiers get their first answer again"
        assert ask(thief, place, payload, p1) == []
    assert p1.obeyed == ["hold", "land"]
    restarted = Vehicle("p1", loopback.member("p1", [loopback.endpoint(3)], []), clock_ahead_s=6.0)
    operator = loopback.member("operator", [], [loopback.endpoint(3)])
    thief = loopback.member("p2", [], [loopback.endpoint(3)], obeys_rules=False)
    until(lambda: bool(ask(operator, place, recorded["hold"], restarted)))
    assert restarted.obeyed == [], "it has forgotten the identifier, and the command is too old"
    assert ask(thief, place, recorded["land"], restarted) == []
    assert restarted.obeyed == []
    assert ask(operator, place, recorded["land"], restarted) == [place]
    assert restarted.obeyed == ["land"], "an operator with a wrong clock can end a flight; nobody else can send this"


def test_what_is_too_large_is_refused_and_told_and_what_is_huge_does_not_arrive(
    loopback: Loopback, pair: tuple[Vehicle, Vehicle]
) -> None:
    p1, e1 = pair
    rogue = loopback.member("p2", [], [loopback.endpoint(0)], obeys_rules=False)
    publisher = rogue.declare_publisher(key(FLEET, "p2", "state"), congestion_control=zenoh.CongestionControl.BLOCK)

    def told() -> bool:
        publisher.put(bytes(5000))
        p1.tick()
        return bool(p1.complaints)

    until(told)
    assert p1.complaints == ["p2: payload of 5000 bytes: at most 1024 are accepted"]
    seen = p1.session.declare_subscriber(key(FLEET, "p2", "state"), zenoh.handlers.RingChannel(64))
    sizes: list[int] = []

    def small_one_arrives() -> bool:
        publisher.put(bytes(64 * MESSAGE_MAX_BYTES))
        publisher.put(bytes(7))
        p1.tick()
        sizes.extend(len(sample.payload.to_bytes()) for sample in iter(seen.try_recv, None))
        return 7 in sizes

    until(small_one_arrives)
    assert max(sizes) < 64 * MESSAGE_MAX_BYTES
    both_fly_on(p1, e1)


def test_whatever_a_member_sends_the_others_fly_on(loopback: Loopback, pair: tuple[Vehicle, Vehicle]) -> None:
    p1, e1 = pair
    rogue = loopback.member("p2", [], [loopback.endpoint(0)], obeys_rules=False)
    operator = loopback.member("operator", [], [loopback.endpoint(0)])
    publishers = [rogue.declare_publisher(key(FLEET, "p2", kind)) for kind in ("state", "intent")]
    valid = [
        encode(STATE, own_state(time.time()), Header("p2", 1, time.time())),
        encode(INTENT, own_intent(), Header("p2", 1, time.time())),
        command("hold"),
    ]
    spoilt = st.builds(
        lambda payload, cut, changes: bytes(changes.get(index, byte) for index, byte in enumerate(payload[: len(payload) - cut])),
        st.sampled_from(valid),
        st.integers(0, 12),
        st.dictionaries(st.integers(0, 80), st.integers(0, 255), max_size=6),
    )

    @settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
    @given(st.one_of(st.binary(max_size=1100), spoilt))
    def send(payload: bytes) -> None:
        for publisher in publishers:
            publisher.put(payload)
        operator.get(key(FLEET, "p1", COMMAND), payload=payload, timeout=0.2)
        p1.tick()

    send()
    until(lambda: (p1.tick(), bool(p1.complaints))[1])
    both_fly_on(p1, e1)
    assert all(action in ("hold",) for action in p1.obeyed), "only what is still a command was obeyed"


def test_what_is_refused_can_be_recorded_with_who_it_was(keys: Path, loopback: Loopback, tmp_path: Path) -> None:
    arguments = [sys.executable, "-m", "tests.fleet.security.refusing_vehicle", str(keys), loopback.endpoint(0)]
    with subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True, cwd=ROOT) as victim:
        try:
            assert victim.stderr is not None
            assert victim.stderr.readline() == "ready\n"
            liar = loopback.member("p2", [], [loopback.endpoint(0)], obeys_rules=False)
            loopback.with_certificates_of(make_fleet_keys(tmp_path / "keys"), "operator", [loopback.endpoint(0)])
            lie = liar.declare_publisher(key(FLEET, "e1", "state"))
            told: dict[str, int] = {}
            deadline = time.monotonic() + 20.0
            while not ({"put", "connection"} <= {word for sentence in told for word in sentence.split()}):
                assert time.monotonic() < deadline, told
                for _ in range(20):
                    lie.put(b"lie")
                    time.sleep(0.01)
                if select.select([victim.stderr], [], [], 0.0)[0]:
                    told = json.loads(victim.stderr.readline())
        finally:
            victim.kill()
    assert any(sentence == f"'p2' may not put on {key(FLEET, 'e1', 'state')}" for sentence in told), told
    assert any(sentence.startswith("a connection without a valid certificate: ") for sentence in told), told
