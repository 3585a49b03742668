"""Fleet payloads: round trips within the resolution, other versions, and refusal of everything else with a sentence."""

import math
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.messages.codec import (
    MAJOR_VERSION,
    MINOR_VERSION,
    PAYLOAD_MAX_BYTES,
    SAFETY,
    Header,
    Kind,
    MalformedPayloadError,
    decode,
    encode,
)
from flightapp.fleet.messages.command import (
    ACKNOWLEDGEMENT,
    COMMAND,
    Acknowledgement,
    Command,
    decode_acknowledgement,
    decode_command,
    encode_acknowledgement,
    encode_command,
)
from flightapp.fleet.messages.intent import INTENT, Intent
from flightapp.fleet.messages.state import STATE, State

metres = st.floats(-50_000.0, 50_000.0)
triples = st.tuples(metres, metres, metres)
moments = st.floats(-60.0, 60.0)
headers = st.builds(Header, st.sampled_from(["p1", "evader"]), st.integers(0, 2**40), st.floats(0.0, 4e9))
states = st.builds(
    State,
    t_s=moments,
    position_ned_m=triples,
    velocity_ned_m_s=triples,
    yaw_rad=st.floats(-math.pi, math.pi),
    airborne=st.booleans(),
    phase=st.sampled_from(["ready", "pursue"]),
    outcome=st.sampled_from([None, "captured"]),
)
intents = st.builds(
    Intent,
    role=st.sampled_from(["pursuer", "evader"]),
    mission=st.sampled_from(["0123456789ab", ""]),
    system_id=st.integers(1, 255),
    mode=st.sampled_from(["coarse", "fine"]),
    goal_ned_m=st.none() | triples,
    arrival_s=st.none() | moments,
    target_distance_m=st.none() | metres,
    clearance_m=st.none() | metres,
    link_age_s=st.none() | st.floats(0.0, 60.0),
    guards=st.lists(st.sampled_from(["geofence", "separation"]), max_size=3).map(tuple),
)
KINDS = (STATE, INTENT, COMMAND, ACKNOWLEDGEMENT)
HALF_CENTIMETRE_M = 0.00501
HALF_MILLISECOND_S = 0.000501


def near(sent: tuple[float, float, float], got: tuple[float, float, float]) -> bool:
    return math.dist(sent, got) <= HALF_CENTIMETRE_M * math.sqrt(3.0)


@given(states, headers, st.floats(-100.0, 100.0))
def test_a_state_survives_the_network_within_its_resolution(state: State, header: Header, clock_ahead_s: float) -> None:
    sent = replace(state, t_s=header.sent_s + state.t_s)
    got, got_header = decode(STATE, encode(STATE, sent, header), clock_ahead_s)
    assert (got_header.sender, got_header.sequence) == (header.sender, header.sequence)
    assert got_header.sent_s == header.sent_s - clock_ahead_s
    assert abs(got.t_s - (sent.t_s - clock_ahead_s)) <= HALF_MILLISECOND_S, "every stamp is on the receiver's clock"
    assert near(sent.position_ned_m, got.position_ned_m)
    assert near(sent.velocity_ned_m_s, got.velocity_ned_m_s)
    assert abs(got.yaw_rad - sent.yaw_rad) <= HALF_MILLISECOND_S
    assert (got.airborne, got.phase, got.outcome) == (sent.airborne, sent.phase, sent.outcome)


@given(intents, headers)
def test_an_intent_survives_the_network_within_its_resolution(intent: Intent, header: Header) -> None:
    arrival_s = None if intent.arrival_s is None else header.sent_s + intent.arrival_s
    sent = replace(intent, arrival_s=arrival_s)
    got, _ = decode(INTENT, encode(INTENT, sent, header))
    for name in ("role", "mission", "system_id", "mode", "guards"):
        assert getattr(got, name) == getattr(sent, name)
    for name in ("arrival_s", "target_distance_m", "clearance_m", "link_age_s"):
        before, after = getattr(sent, name), getattr(got, name)
        assert (before is None) == (after is None)
        assert before is None or abs(before - after) <= HALF_CENTIMETRE_M
    assert (sent.goal_ned_m is None) == (got.goal_ned_m is None)
    assert sent.goal_ned_m is None or got.goal_ned_m is None or near(sent.goal_ned_m, got.goal_ned_m)


@given(st.sampled_from(KINDS), st.binary(max_size=200), st.booleans())
def test_noise_is_refused_with_a_sentence(kind: Kind[object, msgspec.Struct], noise: bytes, versioned: bool) -> None:
    payload = bytes((MAJOR_VERSION, MINOR_VERSION)) + noise if versioned else noise
    with pytest.raises(MalformedPayloadError, match=r"\w+ \w+"):
        decode(kind, payload)


values = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text(max_size=40) | st.binary(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=6,
)


@given(states, headers, st.data())
def test_a_state_with_one_field_spoilt_is_refused_or_still_a_finite_state(
    state: State, header: Header, data: st.DataObject
) -> None:
    fields = msgspec.msgpack.decode(encode(STATE, replace(state, t_s=header.sent_s), header)[2:])
    spoilt = data.draw(st.sampled_from([fields, fields[3]]))
    spoilt[data.draw(st.integers(0, len(spoilt) - 1))] = data.draw(values)
    try:
        got, got_header = decode(STATE, bytes((MAJOR_VERSION, MINOR_VERSION)) + msgspec.msgpack.encode(fields))
    except MalformedPayloadError:
        return
    numbers = (*got.position_ned_m, *got.velocity_ned_m_s, got.yaw_rad, got.t_s, got_header.sent_s)
    assert all(math.isfinite(number) for number in numbers)


def test_what_is_no_number_is_not_sent() -> None:
    state = State(0.0, (math.nan, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, airborne=True, phase="pursue", outcome=None)
    with pytest.raises(ValueError, match="NaN"):
        encode(STATE, state, Header("p1", 1, 0.0))


def test_an_oversized_payload_is_refused_without_parsing_it() -> None:
    with pytest.raises(MalformedPayloadError, match=f"at most {PAYLOAD_MAX_BYTES}"):
        decode(STATE, b" " * (PAYLOAD_MAX_BYTES + 1))


class _Later(msgspec.Struct, array_like=True, frozen=True):
    """A kind as a newer minor version knows it: one more field than `_Today`."""

    battery_percent: int
    wind_cm_s: int = -1


class _Today(msgspec.Struct, array_like=True, frozen=True):
    battery_percent: int


LATER = Kind("battery", _Later, lambda one, _: one, lambda one, _: one, SAFETY, age_max_s=1.0)
TODAY = Kind("battery", _Today, lambda one, _: one, lambda one, _: one, SAFETY, age_max_s=1.0)


def test_a_newer_minor_version_is_read_and_an_older_one_completed() -> None:
    header = Header("p1", 1, 0.0)
    newer = bytearray(encode(LATER, _Later(80, 250), header))
    newer[1] = MINOR_VERSION + 1
    assert decode(TODAY, bytes(newer))[0] == _Today(80)
    assert decode(LATER, encode(TODAY, _Today(70), header))[0] == _Later(70, -1)


@pytest.mark.parametrize(
    ("payload", "version"), [(bytes((MAJOR_VERSION + 1, 4, 0x90)), f"{MAJOR_VERSION + 1}.4"), (b'{"version": 1}', "1 \\(JSON\\)")]
)
def test_another_major_version_is_refused_by_number(payload: bytes, version: str) -> None:
    with pytest.raises(MalformedPayloadError, match=f"version {version}: this software speaks version {MAJOR_VERSION}"):
        decode_command(payload)


def test_an_unknown_command_names_the_known_ones() -> None:
    payload = encode_command(Command("self-destruct", "1", 0.0, "ann"))
    with pytest.raises(MalformedPayloadError, match="hold, resume, rtl, land, abort"):
        decode_command(payload)


def test_command_and_acknowledgement_survive_the_network() -> None:
    command = Command("land", "7f", 1.7e9 + 0.25, "ann@base")
    assert decode_command(encode_command(command)) == command
    answer = Acknowledgement("p1", "7", False, "too old")
    assert decode_acknowledgement(encode_acknowledgement(answer)) == answer
