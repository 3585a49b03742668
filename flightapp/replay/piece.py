"""The beginning of a recording, and only what it takes to decide it again: small enough to be kept with the tests."""

from __future__ import annotations

from pathlib import Path

from mcap.records import Attachment, Channel, Metadata
from mcap.writer import CompressionType, Writer

from flightapp.core.errors import InputError
from flightapp.recording.recorder import FILE_PROFILE
from flightapp.recording.scan import Scan

OBSERVED = "/observation"
TOPICS = ("/phase", "/obstacles", OBSERVED, "/decision", "/setpoint")


def write_piece(source: Path, target: Path, seconds: float) -> None:
    """Copy the first `seconds` after the first decision of `source` to `target`; InputError where nothing was decided."""
    topics: dict[int, str] = {}
    messages: list[tuple[int, int, bytes]] = []
    kept: list[Metadata | Attachment] = []
    for record in Scan(source).messages(topics):
        if isinstance(record, tuple):
            messages.append(record)
        elif isinstance(record, Channel) and record.topic in TOPICS:
            topics[record.id] = record.topic
        elif isinstance(record, Metadata | Attachment):
            kept.append(record)
    starts_ns = [time_ns for channel, time_ns, _ in messages if topics[channel] == OBSERVED]
    if not starts_ns:
        raise InputError(f"{source}: nothing was decided in this recording")
    end_ns = min(starts_ns) + int(seconds * 1e9)
    with target.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile=FILE_PROFILE)
        channels = {topic: writer.register_channel(topic, "json", schema_id=0) for topic in TOPICS}
        for one in kept:
            if isinstance(one, Metadata):
                writer.add_metadata(one.name, one.metadata)
            else:
                writer.add_attachment(one.create_time, one.log_time, one.name, one.media_type, one.data)
        for channel, time_ns, payload in messages:
            if time_ns <= end_ns:
                writer.add_message(channels[topics[channel]], time_ns, payload, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]
