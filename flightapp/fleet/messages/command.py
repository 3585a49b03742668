"""An operator's wish, sent as a question to each vehicle, and the vehicle's answer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec

from flightapp.fleet.messages.codec import DECISIONS, Header, Kind, decode, encode
from flightapp.fleet.messages.units import Sentence

COMMANDS = ("hold", "resume", "rtl", "land", "abort")
OPERATOR = "operator"
"""The sender in the header; who it was stands in the command."""
TEXT_MAX = 200


@dataclass(frozen=True, slots=True)
class Command:
    """`identifier` makes repeats harmless; `operator`: USER@HOST."""

    action: str
    identifier: str
    sent_s: float
    operator: str


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """A vehicle's answer to a command."""

    vehicle: str
    identifier: str
    accepted: bool
    text: str


class _CommandWire(msgspec.Struct, array_like=True, frozen=True):
    action: Sentence
    identifier: Sentence
    operator: Sentence


class _AcknowledgementWire(msgspec.Struct, array_like=True, frozen=True):
    identifier: Sentence
    accepted: bool
    text: Sentence


def _read_command(wire: _CommandWire, header: Header) -> Command:
    if wire.action not in COMMANDS:
        raise ValueError(f"'{wire.action}': must be one of {', '.join(COMMANDS)}")
    return Command(wire.action, wire.identifier, header.sent_s, wire.operator)


COMMAND = Kind(
    "command",
    _CommandWire,
    lambda command, _: _CommandWire(command.action, command.identifier, command.operator[:TEXT_MAX]),
    _read_command,
    DECISIONS,
    age_max_s=math.inf,
)
"""Whoever receives one judges its age: some are obeyed however old."""
ACKNOWLEDGEMENT = Kind(
    "acknowledgement",
    _AcknowledgementWire,
    lambda answer, _: _AcknowledgementWire(answer.identifier, answer.accepted, answer.text[:TEXT_MAX]),
    lambda wire, header: Acknowledgement(header.sender, wire.identifier, wire.accepted, wire.text),
    DECISIONS,
    age_max_s=math.inf,
)


def encode_command(command: Command) -> bytes:
    return encode(COMMAND, command, Header(OPERATOR, 0, command.sent_s))


def decode_command(payload: bytes) -> Command:
    """The command in `payload`; MalformedPayloadError otherwise."""
    return decode(COMMAND, payload)[0]


def encode_acknowledgement(answer: Acknowledgement) -> bytes:
    return encode(ACKNOWLEDGEMENT, answer, Header(answer.vehicle, 0, 0.0))


def decode_acknowledgement(payload: bytes) -> Acknowledgement:
    """The answer in `payload`; MalformedPayloadError otherwise."""
    return decode(ACKNOWLEDGEMENT, payload)[0]
