"""Reads recordings, also those of a process that was killed while it wrote."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Attachment, Metadata
from mcap.records import Channel as McapChannel

from flightapp.core.types import Array
from flightapp.recording.scan import Scan
from flightapp.recording.series import Messages, Series, no_messages

__all__ = ["Recording", "Series", "discs_of", "read_recording"]


@dataclass(frozen=True, slots=True)
class Recording:
    """What one file holds. `complete` is False if it was cut off or damaged: everything else of it is here.

    note: what is amiss with the file, one sentence; empty if nothing is.
    """

    path: Path
    vehicle: str
    complete: bool
    metadata: Mapping[str, Mapping[str, str]]
    attachments: Mapping[str, bytes]
    series: Mapping[str, Series] = field(repr=False)
    note: str = ""

    def topic(self, name: str) -> Series:
        """The series of one topic; empty if nothing was recorded on it."""
        return self.series.get(name) or no_messages(name)

    def shifted(self, shift_s: float) -> Recording:
        """The same recording on another time base: `shift_s` is added to its times."""
        if shift_s == 0.0:
            return self
        return replace(self, series={topic: series.shifted(shift_s) for topic, series in self.series.items()})


def read_recording(path: Path) -> Recording:
    """The recording in `path`; InputError with one sentence if it is none.

    The vehicle's name is `vehicle` in the metadata `run`, or the file's name without its ending.
    """
    scan = Scan(path)
    topics: dict[int, str] = {}
    times: dict[str, list[int]] = {}
    payloads: dict[str, list[bytes]] = {}
    metadata: dict[str, dict[str, str]] = {}
    attachments: dict[str, bytes] = {}
    for record in scan.messages(topics):
        if isinstance(record, tuple):
            topic = topics[record[0]]
            times.setdefault(topic, []).append(record[1])
            payloads.setdefault(topic, []).append(record[2])
        elif isinstance(record, McapChannel) and record.message_encoding == "json":
            topics[record.id] = record.topic
        elif isinstance(record, Metadata):
            metadata.setdefault(record.name, {}).update(record.metadata)
        elif isinstance(record, Attachment):
            attachments[record.name] = record.data
    series = {topic: _series(topic, times[topic], payloads[topic]) for topic in times}
    vehicle = metadata.get("run", {}).get("vehicle", path.stem)
    return Recording(path, vehicle, scan.complete, metadata, attachments, series, scan.note)


def discs_of(message: Mapping[str, Any]) -> Array:
    """The discs (n, 7) of one `/obstacles` message, columns DISC_COLUMNS; null heights are infinite again."""
    discs = np.array([[_number(value) for value in row] for row in message["discs"]], dtype=np.float64).reshape(-1, 7)
    discs[np.isnan(discs[:, 5]), 5] = -math.inf
    discs[np.isnan(discs[:, 6]), 6] = math.inf
    return discs


def _series(topic: str, times_ns: list[int], payloads: list[bytes]) -> Series:
    stamps = np.array(times_ns, dtype=np.uint64)
    order = np.argsort(stamps, kind="stable")
    return Series(topic, stamps[order].astype(np.float64) * 1e-9, Messages(payloads).taken(order.tolist()))


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan
