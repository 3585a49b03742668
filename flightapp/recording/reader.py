"""Reads recordings, also those of a process that was killed while it wrote."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from mcap.records import Attachment, Message, Metadata
from mcap.records import Channel as McapChannel

from flightapp.core.types import Array
from flightapp.recording.scan import Scan


@dataclass(frozen=True, slots=True)
class Series:
    """The messages of one topic in the order of their times `t_s` (n,), fleet time."""

    topic: str
    t_s: Array
    messages: list[dict[str, Any]]

    def __len__(self) -> int:
        return len(self.messages)

    def column(self, name: str) -> Array:
        """One numeric field of every message, (n,); NaN where it is null or absent."""
        return np.array([_number(message.get(name)) for message in self.messages], dtype=np.float64)

    def vectors(self, name: str, width: int = 3) -> Array:
        """One field that is a list of `width` numbers, (n, width); NaN where it is null or absent."""
        empty = [math.nan] * width
        rows = [message.get(name) for message in self.messages]
        good = [row if isinstance(row, list) and len(row) == width else empty for row in rows]
        return np.array([[_number(value) for value in row] for row in good], dtype=np.float64).reshape(-1, width)

    def texts(self, name: str) -> list[str]:
        """One text field of every message; empty where it is null or absent."""
        return [str(message.get(name) or "") for message in self.messages]


@dataclass(frozen=True, slots=True)
class Recording:
    """What one file holds. `complete` is False if it was cut off: everything up to the cut is here."""

    path: Path
    vehicle: str
    complete: bool
    metadata: Mapping[str, Mapping[str, str]]
    attachments: Mapping[str, bytes]
    series: Mapping[str, Series] = field(repr=False)

    def topic(self, name: str) -> Series:
        """The series of one topic; empty if nothing was recorded on it."""
        return self.series.get(name) or Series(name, np.zeros(0), [])


def read_recording(path: Path) -> Recording:
    """The recording in `path`; InputError with one sentence if it is none.

    The vehicle's name is `vehicle` in the metadata `run`, or the file's name without its ending.
    """
    scan = Scan(path)
    topics: dict[int, str] = {}
    times: dict[str, list[int]] = {}
    messages: dict[str, list[dict[str, Any]]] = {}
    metadata: dict[str, dict[str, str]] = {}
    attachments: dict[str, bytes] = {}
    for record in scan:
        if isinstance(record, Message) and record.channel_id in topics:
            content = _content(record.data)
            if content is not None:
                topic = topics[record.channel_id]
                times.setdefault(topic, []).append(record.log_time)
                messages.setdefault(topic, []).append(content)
        elif isinstance(record, McapChannel) and record.message_encoding == "json":
            topics[record.id] = record.topic
        elif isinstance(record, Metadata):
            metadata.setdefault(record.name, {}).update(record.metadata)
        elif isinstance(record, Attachment):
            attachments[record.name] = record.data
    series = {topic: _series(topic, times[topic], messages[topic]) for topic in times}
    vehicle = metadata.get("run", {}).get("vehicle", path.stem)
    return Recording(path, vehicle, scan.complete, metadata, attachments, series)


def discs_of(message: Mapping[str, Any]) -> Array:
    """The discs (n, 7) of one `/obstacles` message, columns DISC_COLUMNS; null heights are infinite again."""
    discs = np.array([[_number(value) for value in row] for row in message["discs"]], dtype=np.float64).reshape(-1, 7)
    discs[np.isnan(discs[:, 5]), 5] = -math.inf
    discs[np.isnan(discs[:, 6]), 6] = math.inf
    return discs


def _series(topic: str, times_ns: list[int], messages: list[dict[str, Any]]) -> Series:
    order = np.argsort(np.array(times_ns, dtype=np.uint64), kind="stable")
    t_s = np.array(times_ns, dtype=np.uint64)[order].astype(np.float64) * 1e-9
    return Series(topic, t_s, [messages[index] for index in order])


def _content(data: bytes) -> dict[str, Any] | None:
    """The message as a dict; None if it is not a JSON object, which no recorder of ours writes."""
    try:
        content = orjson.loads(data)
    except orjson.JSONDecodeError:
        return None
    return content if isinstance(content, dict) else None


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan
