"""One flight log of PX4 (`.ulg`), read once: topics as columns, on a time line that begins with the log."""

from __future__ import annotations

import contextlib
import io
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pyulog import ULog

from flightapp.analysis.ulog.spans import Span, spans_of
from flightapp.core.errors import InputError
from flightapp.core.types import Array

MAGIC = b"ULog\x01\x12\x35"
HEADER_LENGTH = 16
_DEFINITION_KINDS, _DATA_KINDS = frozenset(b"BFIMPQ"), frozenset(b"ALC")
LENGTH_MAX_S = 86_400.0
"""A sample further from the start of its log has a damaged time."""
ARMED = 2
"""vehicle_status.arming_state"""


@dataclass(frozen=True, slots=True)
class Topic:
    """One instance of one topic: times (n,) in s since the log began (negative: published before) and its fields."""

    name: str
    t_s: Array
    fields: Mapping[str, Array] = field(repr=False)

    def __len__(self) -> int:
        return len(self.t_s)

    def column(self, name: str) -> Array | None:
        """One field (n,) as float64; None where this version of PX4 does not have it."""
        return self.fields.get(name)

    def vectors(self, names: Sequence[str]) -> Array | None:
        """Several fields as columns (n, len(names)); None where one is not there."""
        columns = [self.fields[name] for name in names if name in self.fields]
        return np.column_stack(columns) if len(columns) == len(names) else None


@dataclass(frozen=True, slots=True)
class Message:
    """One line that PX4 logged. `level` counts as in syslog: 0 emergency to 7 debug."""

    t_s: float
    level: int
    text: str


@dataclass(frozen=True, slots=True)
class FlightLog:
    """Times in s since the log began; `boot_s` turns them into time since the autopilot started.

    `damaged`: bytes in the middle could not be read. `gaps_s`: lengths of the drop-outs of the logger itself.
    """

    path: Path
    boot_s: float
    end_s: float
    topics: Mapping[str, tuple[Topic, ...]]
    parameters: Mapping[str, float]
    information: Mapping[str, str]
    messages: tuple[Message, ...]
    gaps_s: tuple[float, ...]
    damaged: bool

    def topic(self, name: str, instance: int = 0) -> Topic | None:
        """One instance of a topic; None if it was not logged."""
        instances = self.topics.get(name, ())
        return instances[instance] if instance < len(instances) else None

    def armed(self) -> tuple[Span, ...]:
        """When the motors were armed; empty where that was not logged."""
        return self._where("vehicle_status", "arming_state", ARMED)

    def airborne(self) -> tuple[Span, ...]:
        """When it was off the ground, as PX4 detected it; empty where that was not logged."""
        return self._where("vehicle_land_detected", "landed", 0)

    def in_mode(self, nav_state: int) -> tuple[Span, ...]:
        """When it flew in one mode (see `modes`)."""
        return self._where("vehicle_status", "nav_state", nav_state)

    def _where(self, name: str, column: str, value: int) -> tuple[Span, ...]:
        topic = self.topic(name)
        values = None if topic is None else topic.column(column)
        if topic is None or values is None:
            return ()
        return tuple(spans_of(topic.t_s, values == value, self.end_s))


def load_log(path: Path, topics: Sequence[str] | None = None) -> FlightLog:
    """The log in `path`, of all or of some topics; InputError with one sentence if it is none or holds nothing.

    A log that was cut off is read up to the cut.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if not content.startswith(MAGIC):
        raise InputError(f"{path}: not a PX4 log: a .ulg file begins with 'ULog'")
    if not _head_is_whole(content):
        raise InputError(f"{path}: damaged in its head, where the layout of its data stands: nothing can be read")
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            parsed = ULog(io.BytesIO(content), None if topics is None else list(topics))
        log = _log(path, parsed)
    except (
        Exception
    ) as error:  # the parser raises whatever damaged bytes make of it: struct.error, KeyError, UnicodeDecodeError ...
        raise InputError(f"{path}: damaged beyond reading: {type(error).__name__} after {len(content)} bytes were read") from None
    if not log.topics:
        raise InputError(f"{path}: holds no data: {len(content)} bytes, cut off before the first sample")
    return log


def _head_is_whole(content: bytes) -> bool:
    """Whether the definitions can be walked through up to the data, or to the end; in damaged ones the parser never returns."""
    place = HEADER_LENGTH
    while place + 3 <= len(content):
        length, kind = struct.unpack_from("<HB", content, place)
        if kind in _DATA_KINDS:
            return True
        if kind not in _DEFINITION_KINDS:
            return False
        place += 3 + length
    return True


def _log(path: Path, parsed: ULog) -> FlightLog:
    start_us = int(parsed.start_timestamp)
    topics: dict[str, list[Topic]] = {}
    for data in sorted(parsed.data_list, key=lambda one: (one.name, one.multi_id)):
        if len(data.data.get("timestamp", ())):
            topic = _topic(data.name, data.data, start_us)
            if len(topic):
                topics.setdefault(data.name, []).append(topic)
    ends = [float(one.t_s[-1]) for instances in topics.values() for one in instances]
    return FlightLog(
        path=path,
        boot_s=start_us * 1e-6,
        end_s=max(ends, default=0.0),
        topics={name: tuple(instances) for name, instances in topics.items()},
        parameters={name: float(value) for name, value in parsed.initial_parameters.items()},
        information={name: str(value) for name, value in parsed.msg_info_dict.items()},
        messages=tuple(
            Message((int(one.timestamp) - start_us) * 1e-6, int(one.log_level) - ord("0"), " ".join(one.message.split()))
            for one in parsed.logged_messages
        ),
        gaps_s=tuple(float(gap.duration) * 1e-3 for gap in parsed.dropouts),
        damaged=bool(parsed.file_corruption),
    )


def _topic(name: str, columns: Mapping[str, Array], start_us: int) -> Topic:
    t_s: Array = ((columns["timestamp"].astype(np.int64) - start_us) * 1e-6).astype(np.float64)
    possible = np.flatnonzero(np.abs(t_s) < LENGTH_MAX_S)
    order = possible[np.argsort(t_s[possible], kind="stable")]
    fields: dict[str, Array] = {key: values[order].astype(np.float64) for key, values in columns.items() if key != "timestamp"}
    return Topic(name, t_s[order], fields)
