"""What a vehicle means to do and what it knows about itself: sent when it changes, and twice a second."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import msgspec

from flightapp.fleet.messages.codec import RIDERS, Header, Kind
from flightapp.fleet.messages.units import (
    Centimetres,
    Milliseconds,
    Triple,
    Vector,
    Word,
    centimetres,
    metres,
    since,
    stamp,
    triple,
    vector,
)


@dataclass(frozen=True, slots=True)
class Intent:
    """Mission frame NED, fleet time, SI units; None: there is none, or it is not known."""

    role: str
    mission: str
    """Digest of the sender's mission file: vehicles that fly different versions of it do not start together."""
    system_id: int
    """MAVLink system id of the sender's autopilot."""
    mode: str
    goal_ned_m: Triple | None
    arrival_s: float | None
    """When it means to be at the goal."""
    target_distance_m: float | None
    clearance_m: float | None
    link_age_s: float | None
    """Age of the oldest teammate state known to the sender."""
    guards: tuple[str, ...]
    battery_fraction: float | None = None
    """What is left, 0 to 1; None: not measured, or not told (version 2.0)."""


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    role: Word
    mission: Word
    system_id: Annotated[int, msgspec.Meta(ge=0, le=255)]
    mode: Word
    goal_cm: Vector | None
    arrival_ms: Milliseconds | None
    target_distance_cm: Centimetres | None
    clearance_cm: Centimetres | None
    link_age_ms: Milliseconds | None
    guards: Annotated[tuple[Word, ...], msgspec.Meta(max_length=16)]
    battery_percent: Annotated[int, msgspec.Meta(ge=0, le=100)] | None = None


def _pack(intent: Intent, header: Header) -> _Wire:
    return _Wire(
        intent.role,
        intent.mission,
        intent.system_id,
        intent.mode,
        None if intent.goal_ned_m is None else vector(intent.goal_ned_m),
        None if intent.arrival_s is None else since(header.sent_s, intent.arrival_s),
        None if intent.target_distance_m is None else centimetres(intent.target_distance_m),
        None if intent.clearance_m is None else centimetres(intent.clearance_m),
        None if intent.link_age_s is None else round(intent.link_age_s * 1000.0),
        intent.guards,
        None if intent.battery_fraction is None else round(min(max(intent.battery_fraction, 0.0), 1.0) * 100.0),
    )


def _unpack(wire: _Wire, header: Header) -> Intent:
    return Intent(
        wire.role,
        wire.mission,
        wire.system_id,
        wire.mode,
        None if wire.goal_cm is None else triple(wire.goal_cm),
        None if wire.arrival_ms is None else stamp(header.sent_s, wire.arrival_ms),
        None if wire.target_distance_cm is None else metres(wire.target_distance_cm),
        None if wire.clearance_cm is None else metres(wire.clearance_cm),
        None if wire.link_age_ms is None else wire.link_age_ms / 1000.0,
        wire.guards,
        None if wire.battery_percent is None else wire.battery_percent / 100.0,
    )


INTENT = Kind("intent", _Wire, _pack, _unpack, RIDERS, age_max_s=5.0, rides=True)
