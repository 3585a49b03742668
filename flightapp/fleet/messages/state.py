"""A vehicle's motion, 20 times a second to whom it matters: what the others' guards and planners need now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import msgspec

from flightapp.fleet.messages.codec import SAFETY, Header, Kind
from flightapp.fleet.messages.units import (
    Milliradians,
    Milliseconds,
    Triple,
    Vector,
    Word,
    milliradians,
    radians,
    since,
    stamp,
    triple,
    vector,
)


@dataclass(frozen=True, slots=True)
class State:
    """Mission frame NED, fleet time, SI units."""

    t_s: float
    position_ned_m: Triple
    velocity_ned_m_s: Triple
    yaw_rad: float
    airborne: bool
    phase: str
    outcome: str | None
    due_s: float = 0.0
    """When its receiver gets the next one at the latest, from the send time; 0: not told (version 2.0)."""


class _Wire(msgspec.Struct, array_like=True, frozen=True):
    t_ms: Milliseconds
    position_cm: Vector
    velocity_cm_s: Vector
    yaw_mrad: Milliradians
    airborne: bool
    phase: Word
    outcome: Word | None
    due_ms: Annotated[int, msgspec.Meta(ge=0, le=10_000)] = 0


def _pack(state: State, header: Header) -> _Wire:
    return _Wire(
        since(header.sent_s, state.t_s),
        vector(state.position_ned_m),
        vector(state.velocity_ned_m_s),
        milliradians(state.yaw_rad),
        state.airborne,
        state.phase,
        state.outcome,
        round(state.due_s * 1000.0),
    )


def _unpack(wire: _Wire, header: Header) -> State:
    return State(
        stamp(header.sent_s, wire.t_ms),
        triple(wire.position_cm),
        triple(wire.velocity_cm_s),
        radians(wire.yaw_mrad),
        wire.airborne,
        wire.phase,
        wire.outcome,
        wire.due_ms / 1000.0,
    )


STATE = Kind("state", _Wire, _pack, _unpack, SAFETY, age_max_s=1.0)
