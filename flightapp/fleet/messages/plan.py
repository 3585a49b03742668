"""The leader's plan: who closes in from where. Five times a second, so that a lost one is no loss."""

from __future__ import annotations

from typing import Annotated

import msgspec

from flightapp.fleet.coordination.plan import Plan, Seat
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


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    term: Annotated[int, msgspec.Meta(ge=0, le=2**31)]
    version: Annotated[int, msgspec.Meta(ge=1, le=2**31)]
    seats: Annotated[tuple[_SeatWire, ...], msgspec.Meta(min_length=1, max_length=SEATS_MAX)]


def _pack(plan: Plan, header: Header) -> _Wire:
    if len(plan.seats) > SEATS_MAX:
        raise ValueError(f"{len(plan.seats)} pursuers in a plan: at most {SEATS_MAX}")
    return _Wire(plan.term, plan.version, tuple(_seat_wire(seat, header) for seat in plan.seats))


def _seat_wire(seat: Seat, header: Header) -> _SeatWire:
    return _SeatWire(
        seat.vehicle,
        milliradians(seat.bearing_rad),
        centimetres(seat.north_m),
        centimetres(seat.east_m),
        since(header.sent_s, seat.alone_s),
    )


def _unpack(wire: _Wire, header: Header) -> Plan:
    seats = tuple(_seat(one, header) for one in wire.seats)
    plan = Plan(wire.term, wire.version, seats)
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
    )


PLAN = Kind("plan", _Wire, _pack, _unpack, PLANS, age_max_s=1.0)
