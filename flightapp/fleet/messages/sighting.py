"""Where a vehicle's camera saw the target: at most 10 times a second, by those that see it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import msgspec

from flightapp.fleet.messages.codec import RIDERS, Header, Kind
from flightapp.fleet.messages.units import (
    Centimetres,
    Milliradians,
    Milliseconds,
    centimetres,
    metres,
    milliradians,
    radians,
    since,
    stamp,
)


@dataclass(frozen=True, slots=True)
class Sighting:
    """Mission frame, fleet time of the capture, SI units. A camera that looks level measures no height."""

    t_s: float
    north_m: float
    east_m: float
    bearing_rad: float
    """Of the line of sight, clockwise from north, (-pi, pi]."""
    range_sigma_m: float
    """Standard deviation along the line of sight."""
    across_sigma_m: float


_Sigma = Annotated[int, msgspec.Meta(ge=1, le=10_000)]


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    t_ms: Milliseconds
    north_cm: Centimetres
    east_cm: Centimetres
    bearing_mrad: Milliradians
    range_sigma_cm: _Sigma
    across_sigma_cm: _Sigma


def _pack(sighting: Sighting, header: Header) -> _Wire:
    return _Wire(
        since(header.sent_s, sighting.t_s),
        centimetres(sighting.north_m),
        centimetres(sighting.east_m),
        milliradians(sighting.bearing_rad),
        max(1, centimetres(sighting.range_sigma_m)),
        max(1, centimetres(sighting.across_sigma_m)),
    )


def _unpack(wire: _Wire, header: Header) -> Sighting:
    return Sighting(
        stamp(header.sent_s, wire.t_ms),
        metres(wire.north_cm),
        metres(wire.east_cm),
        radians(wire.bearing_mrad),
        metres(wire.range_sigma_cm),
        metres(wire.across_sigma_cm),
    )


def as_heard(sighting: Sighting, sent_s: float) -> Sighting:
    """`sighting` in the resolution in which the others get it: all vehicles filter the same numbers."""
    header = Header("", 0, sent_s)
    return _unpack(_pack(sighting, header), header)


SIGHTING = Kind("sighting", _Wire, _pack, _unpack, RIDERS, age_max_s=1.0, rides=True)
