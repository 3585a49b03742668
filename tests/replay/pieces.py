"""A golden recording with something changed in it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

import orjson
from mcap.records import Attachment, Channel, Metadata
from mcap.writer import Writer

from flightapp.recording.scan import Scan

GOLDEN = Path(__file__).with_name("golden")
PURSUER = GOLDEN / "demo_pursuer.mcap"
Change = Callable[[dict[str, object]], dict[str, object] | None]


def changed(
    target: Path,
    *,
    source: Path = PURSUER,
    profile: str = "flightapp",
    chunk_size: int = 1 << 20,
    run: dict[str, str] | None = None,
    without: Collection[str] = (),
    change: dict[str, Change] | None = None,
) -> Path:
    """`source` as `target`: other metadata `run`, without some topics or attachments, messages changed or (None) left out."""
    topics: dict[int, str] = {}
    with target.open("wb") as file:
        writer = Writer(file, chunk_size=chunk_size)
        writer.start(profile=profile)
        channels: dict[str, int] = {}
        for record in Scan(source).messages(topics):
            if isinstance(record, tuple):
                channel, time_ns, payload = record
                topic = topics[channel]
                message = (change or {}).get(topic, lambda content: content)(orjson.loads(payload))
                if topic not in without and message is not None:
                    writer.add_message(channels[topic], time_ns, orjson.dumps(message), time_ns)
            elif isinstance(record, Channel):
                topics[record.id] = record.topic
                channels[record.topic] = writer.register_channel(record.topic, "json", schema_id=0)
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, {**record.metadata, **(run or {})} if record.name == "run" else record.metadata)
            elif isinstance(record, Attachment) and record.name not in without:
                writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
        writer.finish()
    return target
