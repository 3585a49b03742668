"""A normal, indexed file from a recording that was cut off or damaged."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Attachment, Channel, McapRecord, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from flightapp.core.errors import InputError
from flightapp.recording.recorder import FILE_PROFILE
from flightapp.recording.scan import Scan

_NUMBERS = 65535
"""As many schemas and channels as an MCAP file can number."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was saved: `messages` in all, over `span_s` seconds; `was_complete` if there was nothing to recover.

    note: what was amiss with the recording, one sentence; empty if nothing was.
    """

    output: Path
    messages: int
    span_s: float
    was_complete: bool
    note: str


def recover(path: Path, output: Path) -> Recovery:
    """Copy everything readable in `path` to the new file `output`; InputError if `path` is no recording or `output` exists.

    The output appears under its name only when it is whole; the source is never changed.
    """
    if output.exists():
        raise InputError(f"{output}: exists already; name a new file for the recovered recording")
    scan = Scan(path)
    temporary = output.with_name(f".{output.name}.{os.getpid()}.tmp")
    try:
        messages, span_s = _copy(scan, temporary)
        os.link(temporary, output)
    except FileExistsError:
        raise InputError(f"{output}: exists already; name a new file for the recovered recording") from None
    except OSError as error:
        raise InputError(f"{output}: cannot be written: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
    return Recovery(output, messages, span_s, scan.complete, scan.note)


def _copy(scan: Scan, target: Path) -> tuple[int, float]:
    with target.open("xb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(profile=FILE_PROFILE, library="flightapp recover")
        copy = _Copy(writer)
        for record in scan:
            copy.take(record)
        writer.finish()  # type: ignore[no-untyped-call]
        file.flush()
        os.fsync(file.fileno())
    return copy.messages, 0.0 if copy.first_ns is None else (copy.last_ns - copy.first_ns) * 1e-9


class _Copy:
    """Writes records under new numbers. A number may mean something else later on, where files were joined: the latest counts."""

    def __init__(self, writer: Writer) -> None:
        self.messages = 0
        self.first_ns: int | None = None
        self.last_ns = 0
        self._writer = writer
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}
        self._written: dict[tuple[object, ...], int] = {}

    def take(self, record: McapRecord) -> None:
        if isinstance(record, Message):
            self._message(record)
        elif isinstance(record, Schema):
            self._schema(record)
        elif isinstance(record, Channel):
            self._channel(record)
        elif isinstance(record, Metadata):
            self._writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Attachment):
            self._writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)

    def _message(self, record: Message) -> None:
        number = self._channels.get(record.channel_id)
        if number is None:
            return
        self._writer.add_message(number, record.log_time, record.data, record.publish_time, record.sequence)
        self.first_ns = record.log_time if self.first_ns is None else min(self.first_ns, record.log_time)
        self.last_ns = max(self.last_ns, record.log_time)
        self.messages += 1

    def _schema(self, record: Schema) -> None:
        content = (record.name, record.encoding, record.data)
        if record.id != 0 and self._is_possible(content):
            if content not in self._written:
                self._written[content] = self._writer.register_schema(*content)
            self._schemas[record.id] = self._written[content]

    def _channel(self, record: Channel) -> None:
        """One whose schema is lost is kept without: JSON is readable as it is."""
        schema = self._schemas.get(record.schema_id, 0)
        content = (record.topic, record.message_encoding, schema, tuple(record.metadata.items()))
        if self._is_possible(content):
            if content not in self._written:
                self._written[content] = self._writer.register_channel(
                    record.topic, record.message_encoding, schema, record.metadata
                )
            self._channels[record.id] = self._written[content]

    def _is_possible(self, content: tuple[object, ...]) -> bool:
        return content in self._written or len(self._written) < _NUMBERS
