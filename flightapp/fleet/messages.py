"""What vehicles tell each other. One writer a key; every payload carries version, sequence number and send time."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import orjson

MAJOR_VERSION = 1
PAYLOAD_MAX_BYTES = 4096
COMMANDS = ("hold", "resume", "rtl", "land", "abort")


def state_key(fleet: str, vehicle: str) -> str:
    """Key of a vehicle's shared state; only that vehicle writes it."""
    return f"flightapp/{fleet}/{vehicle}/state"


def command_key(fleet: str, vehicle: str) -> str:
    """Key on which a vehicle answers operator commands; `*` as vehicle reaches all of them."""
    return f"flightapp/{fleet}/{vehicle}/command"


@dataclass(frozen=True, slots=True)
class SharedState:
    """One vehicle as it describes itself: mission frame NED, fleet time, SI units."""

    vehicle: str
    role: str
    sequence: int
    sent_s: float
    t_s: float
    position_ned_m: tuple[float, float, float]
    velocity_ned_m_s: tuple[float, float, float]
    yaw_rad: float
    airborne: bool
    phase: str
    mode: str
    outcome: str | None
    eta_s: float | None
    target_distance_m: float | None
    clearance_m: float | None
    link_age_s: float | None
    """Age of the oldest teammate state known to the sender."""
    mission: str
    """Digest of the sender's mission file: vehicles that fly different versions of it do not start together."""
    guards: tuple[str, ...] = ()
    system_id: int | None = None
    """MAVLink system id of the sender's autopilot; None from software that does not tell."""


class MalformedPayloadError(ValueError):
    """A payload that is not what its key promises; the sentence says why."""


def encode_state(state: SharedState) -> bytes:
    return orjson.dumps({"version": MAJOR_VERSION, **asdict(state)})


def decode_state(payload: bytes) -> SharedState:
    """The state in `payload`; MalformedPayloadError for anything that is not a finite, complete state of this version."""
    fields = _fields(payload)
    try:
        state = SharedState(
            vehicle=str(fields["vehicle"]),
            role=str(fields["role"]),
            sequence=int(fields["sequence"]),
            sent_s=float(fields["sent_s"]),
            t_s=float(fields["t_s"]),
            position_ned_m=_triple(fields["position_ned_m"]),
            velocity_ned_m_s=_triple(fields["velocity_ned_m_s"]),
            yaw_rad=float(fields["yaw_rad"]),
            airborne=bool(fields["airborne"]),
            phase=str(fields["phase"]),
            mode=str(fields["mode"]),
            outcome=None if fields["outcome"] is None else str(fields["outcome"]),
            eta_s=_optional(fields["eta_s"]),
            target_distance_m=_optional(fields["target_distance_m"]),
            clearance_m=_optional(fields["clearance_m"]),
            link_age_s=_optional(fields["link_age_s"]),
            mission=str(fields["mission"]),
            guards=tuple(str(guard) for guard in fields["guards"]),
            system_id=None if fields.get("system_id") is None else int(fields["system_id"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise MalformedPayloadError(f"state payload: {type(error).__name__} {error}") from None
    if not math.isfinite(state.sent_s + state.t_s + state.yaw_rad):
        raise MalformedPayloadError("state payload: a time or the yaw is not finite")
    return state


@dataclass(frozen=True, slots=True)
class Command:
    """An operator's wish; `identifier` makes repeats harmless."""

    action: str
    identifier: str
    sent_s: float
    operator: str


def encode_command(command: Command) -> bytes:
    return orjson.dumps({"version": MAJOR_VERSION, **asdict(command)})


def decode_command(payload: bytes) -> Command:
    """The command in `payload`; MalformedPayloadError otherwise."""
    fields = _fields(payload)
    try:
        command = Command(
            str(fields["action"]), str(fields["identifier"]), float(fields["sent_s"]), str(fields.get("operator", ""))
        )
    except (KeyError, TypeError, ValueError) as error:
        raise MalformedPayloadError(f"command payload: {type(error).__name__} {error}") from None
    if command.action not in COMMANDS:
        raise MalformedPayloadError(f"command '{command.action}': must be one of {', '.join(COMMANDS)}")
    return command


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """A vehicle's answer to a command."""

    vehicle: str
    identifier: str
    accepted: bool
    text: str


def encode_acknowledgement(acknowledgement: Acknowledgement) -> bytes:
    return orjson.dumps({"version": MAJOR_VERSION, **asdict(acknowledgement)})


def decode_acknowledgement(payload: bytes) -> Acknowledgement:
    """The answer in `payload`; MalformedPayloadError otherwise."""
    fields = _fields(payload)
    try:
        return Acknowledgement(str(fields["vehicle"]), str(fields["identifier"]), bool(fields["accepted"]), str(fields["text"]))
    except (KeyError, TypeError) as error:
        raise MalformedPayloadError(f"acknowledgement payload: {type(error).__name__} {error}") from None


def _fields(payload: bytes) -> dict[str, Any]:
    if len(payload) > PAYLOAD_MAX_BYTES:
        raise MalformedPayloadError(f"payload of {len(payload)} bytes: at most {PAYLOAD_MAX_BYTES} are accepted")
    try:
        fields = orjson.loads(payload)
    except orjson.JSONDecodeError as error:
        raise MalformedPayloadError(f"payload is not JSON: {error}") from None
    if not isinstance(fields, dict):
        raise MalformedPayloadError("payload is not a JSON object")
    if fields.get("version") != MAJOR_VERSION:
        raise MalformedPayloadError(f"payload version {fields.get('version')}: this software speaks version {MAJOR_VERSION}")
    return fields


def _triple(values: Any) -> tuple[float, float, float]:
    north, east, down = (float(value) for value in values)
    if not math.isfinite(north + east + down):
        raise ValueError("a vector is not finite")
    return north, east, down


def _optional(value: Any) -> float | None:
    return None if value is None else float(value)
