"""The leader's plan: who closes in from where. Sent again and again, so that a lost one is no loss.

Minor version 1 appends the slot of a seat, and the meeting; 2 whether that can be reached.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from flightapp.fleet.coordination.plan import Meeting, Plan, Seat
from flightapp.fleet.messages.codec import Header, Kind
from flightapp.fleet.messages.lanes import PLANS
from flightapp.fleet.messages.units import (
    Centimetres,
    Milliradians,
    Milliseconds,
    Name,
    centimetres,
    metres,
    milliradians,
    radians,
    since,
    stamp,
)

SEATS_MAX = 20


class _SeatWire(msgspec.Struct, array_like=True, frozen=True):
    vehicle: Name
    bearing_mrad: Milliradians
    north_cm: Centimetres
    east_cm: Centimetres
    alone_ms: Milliseconds
    slot: Annotated[int, msgspec.Meta(ge=-SEATS_MAX, lt=SEATS_MAX)] = 0


class _MeetingWire(msgspec.Struct, array_like=True, frozen=True):
    north_cm: Centimetres
    east_cm: Centimetres
    heading_mrad: Milliradians
    radius_cm: Annotated[int, msgspec.Meta(gt=0, le=10_000_000)]
    t_ms: Milliseconds
    slots: Annotated[int, msgspec.Meta(ge=1, le=SEATS_MAX)]
    closing: bool
    reachable: bool = True


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    term: Annotated[int, msgspec.Meta(ge=0, le=2**31)]
    version: Annotated[int, msgspec.Meta(ge=1, le=2**31)]
    seats: Annotated[tuple[_SeatWire, ...], msgspec.Meta(min_length=1, max_length=SEATS_MAX)]
    meeting: _MeetingWire | None = None


def _pack(plan: Plan, header: Header) -> _Wire:
    if len(plan.seats) > SEATS_MAX:
        raise ValueError(f"{len(plan.seats)} pursuers in a plan: at most {SEATS_MAX}")
    seats = tuple(_seat_wire(seat, header) for seat in plan.seats)
    return _Wire(plan.term, plan.version, seats, None if plan.meeting is None else _meeting_wire(plan.meeting, header))


def _seat_wire(seat: Seat, header: Header) -> _SeatWire:
    return _SeatWire(
        seat.vehicle,
        milliradians(seat.bearing_rad),
        centimetres(seat.north_m),
        centimetres(seat.east_m),
        since(header.sent_s, seat.alone_s),
        seat.slot,
    )


def _meeting_wire(meeting: Meeting, header: Header) -> _MeetingWire:
    return _MeetingWire(
        centimetres(meeting.north_m),
        centimetres(meeting.east_m),
        milliradians(meeting.heading_rad),
        centimetres(meeting.radius_m),
        since(header.sent_s, meeting.t_s),
        meeting.slots,
        meeting.closing,
        meeting.reachable,
    )


def _unpack(wire: _Wire, header: Header) -> Plan:
    seats = tuple(_seat(one, header) for one in wire.seats)
    plan = Plan(wire.term, wire.version, seats, None if wire.meeting is None else _meeting(wire.meeting, header))
    if len(set(plan.members)) != len(seats):
        raise ValueError("a vehicle has two seats")
    return plan


def _seat(one: _SeatWire, header: Header) -> Seat:
    return Seat(
        one.vehicle,
        radians(one.bearing_mrad),
        metres(one.north_cm),
        metres(one.east_cm),
        stamp(header.sent_s, one.alone_ms),
        one.slot,
    )


def _meeting(wire: _MeetingWire, header: Header) -> Meeting:
    return Meeting(
        metres(wire.north_cm),
        metres(wire.east_cm),
        radians(wire.heading_mrad),
        metres(wire.radius_cm),
        stamp(header.sent_s, wire.t_ms),
        wire.slots,
        wire.closing,
        wire.reachable,
    )


PLAN = Kind("plan", _Wire, _pack, _unpack, PLANS, age_max_s=1.0)
