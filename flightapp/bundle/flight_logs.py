"""Copies a log of PX4 (.ulg) for the bundle: thinned out; texts in it are overwritten, the autopilot's serial number too."""

from __future__ import annotations

import struct
from pathlib import Path

from flightapp.bundle.redaction import Redactor
from flightapp.core.errors import InputError

MAGIC = b"ULog\x01\x12\x35"
HEADER_LENGTH = 16
INTERVAL_US = 500_000
_WITH_TEXT = frozenset(b"IMLCPQ")
_FLAGS, _FORMAT, _DATA, _ADD = (ord(letter) for letter in "BFDA")
_STAMP = b"uint64_t timestamp;"


def copy_log(source: Path, target: Path, redactor: Redactor, *, full: bool) -> int:
    """Number of samples kept; InputError if `source` is no log. One that was cut off is copied up to the cut.

    A log with data appended after a crash keeps all its samples: the places of those data stand in its head.
    """
    content = source.read_bytes()
    if not content.startswith(MAGIC) or len(content) < HEADER_LENGTH:
        raise InputError(f"{source}: not a PX4 log: a .ulg file begins with 'ULog'")
    kept = 0
    last_us: dict[int, int] = {}
    layouts: dict[str, bool] = {}
    stamped: set[int] = set()
    with target.open("xb") as file:
        file.write(content[:HEADER_LENGTH])
        for kind, payload in _messages(content):
            if kind == _FLAGS and any(payload[16:40]):
                full = True
            elif kind == _FORMAT:
                name, _, layout = payload.decode(errors="replace").partition(":")
                layouts[name] = layout.startswith(_STAMP.decode())
            elif kind == _ADD and layouts.get(payload[3:].decode(errors="replace")):
                stamped.add(int.from_bytes(payload[1:3], "little"))
            elif kind == _DATA:
                if not full and not _due(payload, stamped, last_us):
                    continue
                kept += 1
                payload = redactor.same_length(payload)
            elif kind in _WITH_TEXT:
                payload = _redacted(kind, payload, redactor)
            file.write(struct.pack("<HB", len(payload), kind) + payload)
    return kept


def _messages(content: bytes) -> list[tuple[int, bytes]]:
    found = []
    place = HEADER_LENGTH
    while place + 3 <= len(content):
        length, kind = struct.unpack_from("<HB", content, place)
        if place + 3 + length > len(content):
            break
        found.append((kind, content[place + 3 : place + 3 + length]))
        place += 3 + length
    return found


def _due(payload: bytes, stamped: set[int], last_us: dict[int, int]) -> bool:
    number = int.from_bytes(payload[:2], "little")
    if number not in stamped or len(payload) < 10:
        return True
    t_us = int.from_bytes(payload[2:10], "little")
    if 0 <= t_us - last_us.get(number, -INTERVAL_US) < INTERVAL_US:
        return False
    last_us[number] = t_us
    return True


def _redacted(kind: int, payload: bytes, redactor: Redactor) -> bytes:
    """Key and value of an information message stand side by side: the key may say that the value is secret."""
    skip = 1 if kind == ord("M") else 0
    if kind not in b"IM" or len(payload) < skip + 1:
        return redactor.same_length(payload)
    end = skip + 1 + payload[skip]
    key, value = payload[skip + 1 : end], payload[end:]
    name = key.split(b" ")[-1]
    return payload[:end] + redactor.same_length(name + b"=" + value)[len(name) + 1 :]
