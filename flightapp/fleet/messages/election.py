"""A pursuer's standing in the election of a leader: see `flightapp.fleet.election`."""

from __future__ import annotations

import math
from typing import Annotated

import msgspec

from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.messages.codec import Header, Kind
from flightapp.fleet.messages.lanes import BEACONS
from flightapp.fleet.messages.units import Name


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    stamp_s: float
    term: Annotated[int, msgspec.Meta(ge=0, le=2**31)]
    role: Role
    backs: Annotated[tuple[tuple[Name, float], ...], msgspec.Meta(max_length=16)]


def _pack(beacon: Beacon, _: Header) -> _Wire:
    return _Wire(beacon.stamp_s, beacon.term, beacon.role, beacon.backs)


def _unpack(wire: _Wire, _: Header) -> Beacon:
    """Stamps stay as they are: each is one machine's own, and comes back to that machine."""
    if not all(map(math.isfinite, (wire.stamp_s, *(stamp_s for _, stamp_s in wire.backs)))):
        raise ValueError("a stamp is not finite")
    return Beacon(wire.stamp_s, wire.term, wire.role, wire.backs)


ELECTION = Kind("election", _Wire, _pack, _unpack, BEACONS, age_max_s=1.0)
