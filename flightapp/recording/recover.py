"""A normal, indexed file from a recording that was cut off."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from flightapp.core.errors import InputError
from flightapp.recording.recorder import FILE_PROFILE
from flightapp.recording.scan import Scan


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was saved: `messages` in all, over `span_s` seconds; `was_complete` if there was nothing to recover."""

    output: Path
    messages: int
    span_s: float
    was_complete: bool


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
    return Recovery(output, messages, span_s, scan.complete)


def _copy(scan: Scan, target: Path) -> tuple[int, float]:
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    first_ns: int | None = None
    last_ns = 0
    count = 0
    with target.open("xb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(profile=FILE_PROFILE, library="flightapp recover")
        for record in scan:
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
            elif isinstance(record, Channel) and record.id not in channels and record.schema_id in schemas:
                channels[record.id] = writer.register_channel(
                    record.topic, record.message_encoding, schemas[record.schema_id], record.metadata
                )
            elif isinstance(record, Message) and record.channel_id in channels:
                writer.add_message(
                    channels[record.channel_id], record.log_time, record.data, record.publish_time, record.sequence
                )
                first_ns = record.log_time if first_ns is None else min(first_ns, record.log_time)
                last_ns = max(last_ns, record.log_time)
                count += 1
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Attachment):
                writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
        writer.finish()  # type: ignore[no-untyped-call]
        file.flush()
        os.fsync(file.fileno())
    return count, 0.0 if first_ns is None else (last_ns - first_ns) * 1e-9
