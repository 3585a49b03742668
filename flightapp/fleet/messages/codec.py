"""The form of every payload: two bytes of version, then one MessagePack array [sender, sequence, sent_s, [fields of the kind]].

Fields have no names: their order is the schema. A newer minor version appends fields; older software passes over those, newer
software gives those that are missing their defaults. Another major version is refused. Types, ranges and lengths are checked
while decoding, by msgspec; what is not declared never reaches the program.

Stamps travel as their distance from `sent_s` (see `units`), so that correcting `sent_s` by a clock offset corrects them all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Generic, TypeVar

import msgspec
import zenoh

from flightapp.fleet.messages.units import Name

MAJOR_VERSION = 2
"""1 was JSON."""
MINOR_VERSION = 2
"""1: a state tells when the next one is due; 2: a plan, whether its meeting can be reached."""
PAYLOAD_MAX_BYTES = 1024
"""Fits one datagram; everything larger is refused before it is looked at."""

M = TypeVar("M")
W = TypeVar("W", bound=msgspec.Struct)


class MalformedPayloadError(ValueError):
    """A payload that is not what its key promises; the sentence says why."""


@dataclass(frozen=True, slots=True)
class Header:
    """Who sent a message, as which of its kind, when: fleet time; on arrival corrected to the receiver's clock."""

    sender: str
    sequence: int
    sent_s: float


@dataclass(frozen=True, slots=True)
class Delivery:
    """How Zenoh treats a publication. Nothing waits for a slow link: what does not fit is dropped."""

    priority: zenoh.Priority
    reliability: zenoh.Reliability
    express: bool
    """Not kept back to share a packet with others."""


SAFETY = Delivery(zenoh.Priority.REAL_TIME, zenoh.Reliability.BEST_EFFORT, express=True)
"""For what is old in a moment: the next one replaces it."""
RIDERS = Delivery(zenoh.Priority.REAL_TIME, zenoh.Reliability.BEST_EFFORT, express=False)
"""As urgent, but sent a moment before something else: Zenoh puts them into the same packet."""
DECISIONS = Delivery(zenoh.Priority.INTERACTIVE_HIGH, zenoh.Reliability.RELIABLE, express=True)
"""For what others wait for."""
ADVICE = Delivery(zenoh.Priority.DATA, zenoh.Reliability.BEST_EFFORT, express=False)
"""For what is useful when it arrives."""


@dataclass(frozen=True, slots=True, eq=False)
class Kind(Generic[M, W]):
    """One kind of message. `pack` may raise ValueError for what cannot be said, `unpack` for what makes no sense."""

    name: str
    wire: type[W]
    pack: Callable[[M, Header], W]
    unpack: Callable[[W, Header], M]
    delivery: Delivery
    age_max_s: float
    """Older ones are dropped on arrival, by the corrected stamp."""
    rides: bool = False
    """Waits for the next state to everybody where that saves packets (`Post.holds`), the newest instead of all before it."""


class _Envelope(msgspec.Struct, Generic[W], array_like=True, frozen=True):
    sender: Name
    sequence: int
    sent_s: float
    content: W


_VERSION = bytes((MAJOR_VERSION, MINOR_VERSION))
_ENCODER = msgspec.msgpack.Encoder()


def encode(kind: Kind[M, Any], message: M, header: Header) -> bytes:
    """The payload; ValueError where the message cannot be said, a position that is no number for one."""
    content = kind.pack(message, header)
    return _VERSION + _ENCODER.encode(_Envelope(header.sender, header.sequence, header.sent_s, content))


def decode(kind: Kind[M, Any], payload: bytes, clock_ahead_s: float = 0.0) -> tuple[M, Header]:
    """The message in `payload` and its header; MalformedPayloadError for anything else.

    clock_ahead_s: what the sender's clock is ahead of the own; all stamps are corrected by it.
    """
    envelope = open_envelope(kind, payload)
    header = Header(envelope.sender, envelope.sequence, envelope.sent_s - clock_ahead_s)
    try:
        return kind.unpack(envelope.content, header), header
    except (ValueError, OverflowError) as error:
        raise MalformedPayloadError(f"{kind.name} payload: {error}") from None


def open_envelope(kind: Kind[Any, W], payload: bytes) -> _Envelope[W]:
    """The payload's parts as they travelled, validated."""
    if len(payload) > PAYLOAD_MAX_BYTES:
        raise MalformedPayloadError(f"payload of {len(payload)} bytes: at most {PAYLOAD_MAX_BYTES} are accepted")
    if len(payload) < len(_VERSION):
        raise MalformedPayloadError(f"{kind.name} payload of {len(payload)} bytes has no version")
    if payload[0] != MAJOR_VERSION:
        raise MalformedPayloadError(
            f"{kind.name} payload of version {_version_of(payload)}: this software speaks version "
            f"{MAJOR_VERSION}.{MINOR_VERSION}; fly one version of it on all machines"
        )
    try:
        envelope = _decoder(kind.wire).decode(memoryview(payload)[len(_VERSION) :])
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise MalformedPayloadError(f"{kind.name} payload: {error}") from None
    if not math.isfinite(envelope.sent_s):
        raise MalformedPayloadError(f"{kind.name} payload: the send time is not finite")
    return envelope


@cache
def _decoder(wire: type[W]) -> msgspec.msgpack.Decoder[_Envelope[W]]:
    return msgspec.msgpack.Decoder(_Envelope[wire])  # type: ignore[valid-type]


def _version_of(payload: bytes) -> str:
    return "1 (JSON)" if payload[:1] == b"{" else f"{payload[0]}.{payload[1]}"
