"""Fleet payloads: round trips, and refusal of everything else with a sentence."""

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.messages import (
    PAYLOAD_MAX_BYTES,
    Acknowledgement,
    Command,
    MalformedPayloadError,
    SharedState,
    decode_acknowledgement,
    decode_command,
    decode_state,
    encode_acknowledgement,
    encode_command,
    encode_state,
)

finite = st.floats(allow_nan=False, allow_infinity=False, width=32)
triples = st.tuples(finite, finite, finite)
states = st.builds(
    SharedState,
    vehicle=st.sampled_from(["p1", "p2"]),
    role=st.sampled_from(["pursuer", "evader"]),
    sequence=st.integers(0, 2**31),
    sent_s=finite,
    t_s=finite,
    position_ned_m=triples,
    velocity_ned_m_s=triples,
    yaw_rad=finite,
    airborne=st.booleans(),
    phase=st.sampled_from(["ready", "pursue"]),
    mode=st.sampled_from(["coarse", "fine"]),
    outcome=st.sampled_from([None, "captured"]),
    eta_s=st.none() | finite,
    target_distance_m=st.none() | finite,
    clearance_m=st.none() | finite,
    link_age_s=st.none() | finite,
    mission=st.sampled_from(["0123456789ab", ""]),
    guards=st.lists(st.sampled_from(["geofence", "separation"]), max_size=3).map(tuple),
)


@given(states)
def test_a_state_survives_the_network(state: SharedState) -> None:
    assert decode_state(encode_state(state)) == state


def test_a_state_is_small_enough_for_ten_vehicles_on_one_radio() -> None:
    state = SharedState(
        "p1", "pursuer", 10**6, 1.7e9 + 0.123456, 1.7e9, (12.345678, -23.456789, -5.0), (4.1, -2.2, 0.1), 1.234567, True,
        "pursue", "coarse", None, 12.345, 23.456, 1.234, 0.034, "0123456789ab", ("obstacle_stop",),
    )  # fmt: skip
    assert len(encode_state(state)) < 600


@given(st.binary(max_size=400))
def test_noise_is_refused_with_a_sentence(payload: bytes) -> None:
    for decode in (decode_state, decode_command, decode_acknowledgement):
        with pytest.raises(MalformedPayloadError, match=r"\w+ \w+"):
            decode(payload)


@given(states, st.data())
def test_a_state_with_one_field_spoilt_is_refused_or_still_a_finite_state(state: SharedState, data: st.DataObject) -> None:
    fields = orjson.loads(encode_state(state))
    spoilt = data.draw(st.sampled_from(sorted(fields)))
    fields[spoilt] = data.draw(st.sampled_from([None, "x", [], {}, 1e400, [1, 2], "nan"]))
    try:
        decoded = decode_state(orjson.dumps(fields))
    except MalformedPayloadError:
        return
    assert all(abs(value) < float("inf") for value in decoded.position_ned_m)


def test_an_oversized_payload_is_refused_without_parsing_it() -> None:
    with pytest.raises(MalformedPayloadError, match=f"at most {PAYLOAD_MAX_BYTES}"):
        decode_state(b" " * (PAYLOAD_MAX_BYTES + 1))


def test_another_version_is_refused_by_number() -> None:
    with pytest.raises(MalformedPayloadError, match="version 2: this software speaks version 1"):
        decode_command(b'{"version": 2, "action": "land"}')


def test_an_unknown_command_names_the_known_ones() -> None:
    payload = encode_command(Command("self-destruct", "1", 0.0, "ann"))
    with pytest.raises(MalformedPayloadError, match="hold, resume, rtl, land, abort"):
        decode_command(payload)


def test_acknowledgement_round_trip() -> None:
    answer = Acknowledgement("p1", "7", False, "too old")
    assert decode_acknowledgement(encode_acknowledgement(answer)) == answer
