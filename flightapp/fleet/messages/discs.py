"""Obstacles that one vehicle's camera sees and that others may meet, once a second, a dozen at most: see `fleet.sharing`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import msgspec

from flightapp.fleet.messages.codec import RIDERS, Header, Kind
from flightapp.fleet.messages.units import Centimetres, Milliseconds, centimetres, metres, since, stamp

DISCS_MAX = 12


@dataclass(frozen=True, slots=True)
class Disc:
    """Mission frame; radius not inflated; velocity of the obstacle itself."""

    north_m: float
    east_m: float
    radius_m: float
    v_north_m_s: float
    v_east_m_s: float


@dataclass(frozen=True, slots=True)
class Discs:
    """Where the obstacles were at `t_s`, fleet time. They only ever add to what a receiver sees itself; none frees anything."""

    t_s: float
    discs: tuple[Disc, ...]


class _DiscWire(msgspec.Struct, array_like=True, frozen=True):
    north_cm: Centimetres
    east_cm: Centimetres
    radius_cm: Annotated[int, msgspec.Meta(ge=1, le=5_000)]
    v_north_cm_s: Centimetres = 0
    v_east_cm_s: Centimetres = 0


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    t_ms: Milliseconds
    discs: Annotated[tuple[_DiscWire, ...], msgspec.Meta(max_length=DISCS_MAX)]


def _pack(discs: Discs, header: Header) -> _Wire:
    if len(discs.discs) > DISCS_MAX:
        raise ValueError(f"{len(discs.discs)} discs: at most {DISCS_MAX} are shared")
    return _Wire(since(header.sent_s, discs.t_s), tuple(_disc_wire(disc) for disc in discs.discs))


def _disc_wire(disc: Disc) -> _DiscWire:
    return _DiscWire(
        centimetres(disc.north_m),
        centimetres(disc.east_m),
        max(1, centimetres(disc.radius_m)),
        centimetres(disc.v_north_m_s),
        centimetres(disc.v_east_m_s),
    )


def _unpack(wire: _Wire, header: Header) -> Discs:
    return Discs(stamp(header.sent_s, wire.t_ms), tuple(_disc(one) for one in wire.discs))


def _disc(one: _DiscWire) -> Disc:
    return Disc(
        metres(one.north_cm),
        metres(one.east_cm),
        metres(one.radius_cm),
        metres(one.v_north_cm_s),
        metres(one.v_east_cm_s),
    )


DISCS = Kind("discs", _Wire, _pack, _unpack, RIDERS, age_max_s=2.0, rides=True)
