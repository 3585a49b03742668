"""Plans and verdicts on the wire: what is said is heard, it fits a datagram, and nonsense is refused."""

from __future__ import annotations

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.coordination.agreement import Verdict
from flightapp.fleet.coordination.plan import Meeting, Plan, Seat, assignment_of
from flightapp.fleet.coordination.sector_plan import ARRIVAL_MAX_S
from flightapp.fleet.messages.codec import MAJOR_VERSION, PAYLOAD_MAX_BYTES, Header, MalformedPayloadError, decode, encode
from flightapp.fleet.messages.plan import PLAN
from flightapp.fleet.messages.verdict import VERDICT

NOW_S = 1_790_000_000.25
HEADER = Header("p1", 7, NOW_S)
far = st.floats(-5000.0, 5000.0)
names = st.text("abcdefgh0123", min_size=1, max_size=20)
times = st.floats(-1.0, ARRIVAL_MAX_S).map(NOW_S.__add__)
seats = st.builds(Seat, names, st.floats(-math.pi, math.pi), far, far, times)
counts = st.integers(1, 2**31)


@given(st.lists(seats, min_size=1, max_size=10, unique_by=lambda seat: seat.vehicle), counts, counts)
def test_a_plan_arrives_as_it_was_sent(given_seats: list[Seat], term: int, version: int) -> None:
    plan = Plan(term, version, tuple(given_seats))
    payload = encode(PLAN, plan, HEADER)
    assert len(payload) <= PAYLOAD_MAX_BYTES
    heard, _ = decode(PLAN, payload, clock_ahead_s=0.5)
    assert (heard.rank, heard.members) == (plan.rank, plan.members)
    for seat, sent in zip(heard.seats, plan.seats, strict=True):
        assert seat.bearing_rad == pytest.approx(sent.bearing_rad, abs=1e-3)
        assert (seat.north_m, seat.east_m) == pytest.approx((sent.north_m, sent.east_m), abs=0.01)
        assert seat.alone_s == pytest.approx(sent.alone_s - 0.5, abs=0.002), "on the receiver's clock"


def test_a_plan_with_two_seats_for_one_or_none_at_all_is_refused() -> None:
    seat = Seat("p1", 0.0, 0.0, 0.0, NOW_S)
    for bad in (Plan(1, 1, (seat, seat)), Plan(1, 1, ())):
        with pytest.raises(MalformedPayloadError):
            decode(PLAN, encode(PLAN, bad, HEADER))


def test_a_verdict_arrives_as_it_was_sent() -> None:
    verdict = Verdict(frozenset(("p1", "p2", "p3")))
    heard, _ = decode(VERDICT, encode(VERDICT, verdict, HEADER))
    assert heard == verdict


def test_a_meeting_and_its_slots_travel_and_a_plan_without_them_is_read_as_before() -> None:
    at = Meeting(30.25, -4.5, 3.1, 3.2, NOW_S + 12.5, 5, closing=True)
    plan = Plan(3, 7, (Seat("p1", 0.5, 31.0, -4.0, NOW_S + 9.0, 4), Seat("p2", -3.1, 24.0, -4.0, NOW_S + 20.0, -1)), at)
    heard, _ = decode(PLAN, encode(PLAN, plan, HEADER))
    assert heard.meeting is not None
    assert (heard.meeting.slots, heard.meeting.closing, [seat.slot for seat in heard.seats]) == (5, True, [4, -1])
    assert heard.arrival_s == pytest.approx(NOW_S + 12.5)
    told = assignment_of(heard, "p1")
    assert told is not None
    assert told.rendezvous is not None
    assert (told.rendezvous.slot, told.rendezvous.radius_m) == (4, 3.2)
    sent = msgspec.msgpack.decode(encode(PLAN, plan, HEADER)[2:])
    sent[3] = [*sent[3][:2], [seat[:5] for seat in sent[3][2]]]
    older, _ = decode(PLAN, bytes((MAJOR_VERSION, 0)) + msgspec.msgpack.encode(sent))
    assert (older.meeting, [seat.slot for seat in older.seats]) == (None, [0, 0])
