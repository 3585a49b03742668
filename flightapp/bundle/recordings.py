"""Copies a recording (.mcap) for the bundle: thinned out, and every text in it redacted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import orjson
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from flightapp.bundle.redaction import Redactor
from flightapp.recording.recorder import FILE_PROFILE
from flightapp.recording.scan import Scan

INTERVAL_S = 0.5
"""Of the messages of one topic that are kept."""
WHOLE_TOPICS = ("/event", "/phase")
_BULK = ("image", "pointcloud")
"""In names of schemas that are left out of a thinned copy."""


@dataclass(frozen=True, slots=True)
class Copied:
    """`was_complete`: the recording had its end. `withheld`: binary messages with something in them that must not leave."""

    messages: int
    thinned: int
    withheld: int
    was_complete: bool


@dataclass(slots=True)
class _Counts:
    messages: int = 0
    thinned: int = 0
    withheld: int = 0


def copy_recording(source: Path, target: Path, redactor: Redactor, *, full: bool) -> Copied:
    """InputError if `source` is no recording; one that was cut off is copied up to the cut."""
    scan = Scan(source)
    counts = _Counts()
    with target.open("xb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile=FILE_PROFILE, library="flightapp bundle")
        _copy(scan, writer, redactor, counts, full=full)
        writer.finish()  # type: ignore[no-untyped-call]
    return Copied(counts.messages, counts.thinned, counts.withheld, scan.complete)


def texts_of(source: Path) -> list[str]:
    """All texts of a recording outside the messages of its fast topics: to learn names from."""
    texts: list[str] = []
    topics: dict[int, str] = {}
    for record in Scan(source):
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message) and topics.get(record.channel_id) in WHOLE_TOPICS:
            texts.append(record.data.decode(errors="replace"))
        elif isinstance(record, Metadata):
            texts += record.metadata.values()
        elif isinstance(record, Attachment):
            texts.append(record.data.decode(errors="replace"))
    return texts


def _copy(scan: Scan, writer: Writer, redactor: Redactor, counts: _Counts, *, full: bool) -> None:
    schemas: dict[int, int] = {0: 0}
    bulk: set[int] = set()
    channels: dict[int, tuple[int, Channel]] = {}
    last_ns: dict[int, int] = {}
    for record in scan:
        if isinstance(record, Schema) and record.id not in schemas:
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
            if any(word in record.name.lower() for word in _BULK):
                bulk.add(record.id)
        elif isinstance(record, Channel) and record.id not in channels and record.schema_id in schemas:
            known = redactor.value(dict(record.metadata))
            number = writer.register_channel(record.topic, record.message_encoding, schemas[record.schema_id], known)
            channels[record.id] = number, record
        elif isinstance(record, Message) and record.channel_id in channels:
            number, channel = channels[record.channel_id]
            due = record.log_time - last_ns.get(number, -(10**18)) >= INTERVAL_S * 1e9
            if not full and (channel.schema_id in bulk or not (due or channel.topic in WHOLE_TOPICS)):
                counts.thinned += 1
                continue
            data = _redacted(channel, record.data, redactor)
            if data is None:
                counts.withheld += 1
                continue
            last_ns[number] = record.log_time
            writer.add_message(number, record.log_time, data, record.publish_time, record.sequence)
            counts.messages += 1
        elif isinstance(record, Metadata):
            writer.add_metadata(record.name, redactor.value(dict(record.metadata)))
        elif isinstance(record, Attachment):
            _attach(writer, record, redactor)


def _redacted(channel: Channel, data: bytes, redactor: Redactor) -> bytes | None:
    """JSON with its texts redacted; other encodings as they are, or None where something in them must not leave."""
    if channel.message_encoding != "json":
        return data if redactor.clean(data) else None
    try:
        content = orjson.loads(data)
    except orjson.JSONDecodeError:
        return redactor.text(data.decode(errors="replace")).encode()
    redacted = redactor.value(content)
    return data if redacted == content else orjson.dumps(redacted)


def _attach(writer: Writer, record: Attachment, redactor: Redactor) -> None:
    """Input files are text; anything else is not let out."""
    try:
        text = redactor.text(record.data.decode())
    except UnicodeDecodeError:
        return
    writer.add_attachment(record.create_time, record.log_time, redactor.text(record.name), record.media_type, text.encode())
