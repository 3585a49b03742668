"""Who asked what of which vehicle, and what they answered: one line of JSON a command, only ever appended."""

from __future__ import annotations

import getpass
import socket
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import orjson

from flightapp.fleet.messages.command import Command
from flightapp.fleet.operator import Answer


def operator_name() -> str:
    """Person and machine, as far as the system tells: USER@HOST."""
    try:
        user = getpass.getuser()
    except (KeyError, OSError):
        user = "unknown"
    return f"{user}@{socket.gethostname()}"


def append_record(file: Path, fleet: str, command: Command, vehicles: Sequence[str], answers: Sequence[Answer]) -> str:
    """Write the record; empty, or one sentence why that failed: a full disk must not keep a command from being sent."""
    user, _, host = command.operator.rpartition("@")
    record = {
        "time": datetime.fromtimestamp(command.sent_s, UTC).isoformat(timespec="milliseconds"),
        "sent_s": command.sent_s,
        "user": user,
        "host": host,
        "fleet": fleet,
        "action": command.action,
        "identifier": command.identifier,
        "vehicles": list(vehicles),
        "answers": [as_json(answer) for answer in answers],
    }
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("ab") as lines:
            lines.write(orjson.dumps(record) + b"\n")
    except OSError as error:
        return f"the command is not recorded: {file}: {error.strerror or error}"
    return ""


def as_json(answer: Answer) -> dict[str, object]:
    """One answer for machines; `round_trip_ms` null where there was none."""
    round_trip_ms = None if answer.round_trip_s is None else round(answer.round_trip_s * 1e3, 1)
    return {"vehicle": answer.vehicle, "accepted": answer.accepted, "text": answer.text, "round_trip_ms": round_trip_ms}
