"""What `flightapp keys` prints: what goes where, and how long it is good."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from flightapp.fleet.security.keys import AUTHORITY_FOLDER, Handed, KeyWish


def as_json(wish: KeyWish, handed: Sequence[Handed]) -> dict[str, Any]:
    """For machines; times in UTC."""
    members = [
        {"name": one.name, "folder": str(one.folder), "hosts": list(one.hosts), "valid_until": _time(one), "new": one.is_new}
        for one in handed
    ]
    return {"fleet": wish.fleet, "authority": str(wish.folder / AUTHORITY_FOLDER), "members": members}


def as_text(wish: KeyWish, handed: Sequence[Handed]) -> str:
    """For a person."""
    lines = []
    for one in handed:
        made = "made" if one.is_new else "was there, left as it is"
        whose = "the operator's machine" if one.name in wish.operators else f"vehicle {one.name}"
        lines.append(f"{one.folder}: to {whose}, and only there; valid until {_time(one)}; for {', '.join(one.hosts)}; {made}")
    lines.append(f"{wish.folder / AUTHORITY_FOLDER}: to no vehicle; whoever has its key can make members of the fleet")
    lines.append('on each vehicle, in the profile: [network] certificates = "FOLDER" and endpoints quic/HOST:PORT')
    return "\n".join(lines)


def _time(one: Handed) -> str:
    return datetime.fromtimestamp(one.ends_s, UTC).isoformat(timespec="minutes")
