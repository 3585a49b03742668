"""One MCAP file that is being written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import foxglove
from foxglove import Context
from foxglove.mcap import MCAPCompression, MCAPWriteOptions

from flightapp.recording import file_format
from flightapp.recording.channels import Channel
from flightapp.recording.schema import encoding_of, schema_of
from flightapp.recording.sink import Sink

FILE_PROFILE = "flightapp"
"""Profile in the header of every recording: tells ours from other MCAP files."""

Outlet = Callable[[bytes, int], None]
"""Takes one message's bytes and its time, ns."""


def outlets_of(context: Context, channels: tuple[Channel, ...]) -> dict[str, Outlet]:
    """Where the messages of each topic go: to every file and server of `context`."""
    return {channel.topic: _outlet(context, channel) for channel in channels}


def _outlet(context: Context, channel: Channel) -> Outlet:
    raw = foxglove.Channel(
        channel.topic,
        message_encoding=encoding_of(channel.message),
        schema=schema_of(channel.message),
        context=context,
        metadata={"purpose": channel.purpose, "rate_hz": f"{channel.rate_hz:g}"},
    )
    return lambda payload, time_ns: raw.log(payload, log_time=time_ns)


class McapOutput:
    """The file behind a context's channels. Only finished chunks reach it: whatever was flushed survives the process."""

    def __init__(self, context: Context, topics: frozenset[str], sink: Sink, chunk_bytes: int) -> None:
        self._sink = sink
        self._writer: Any = foxglove.open_mcap(
            sink,
            context=context,
            channel_filter=lambda channel: channel.topic in topics,
            writer_options=MCAPWriteOptions(
                compression=MCAPCompression.Lz4, profile=FILE_PROFILE, chunk_size=chunk_bytes, disable_seeking=True
            ),
        )
        self.metadata(file_format.METADATA, file_format.CURRENT)

    @property
    def error(self) -> str | None:
        """Why nothing is written any more; None while all is well."""
        return self._sink.error

    def metadata(self, name: str, texts: dict[str, str]) -> None:
        self._writer.write_metadata(name, texts)

    def attach(self, name: str, data: bytes, time_ns: int) -> None:
        media_type = "application/toml" if name.endswith(".toml") else "application/octet-stream"
        self._writer.attach(log_time=time_ns, create_time=time_ns, name=name, media_type=media_type, data=data)

    def flush(self) -> None:
        """Finish the chunk and hand it to the disk: survives a power cut from here on."""
        self._writer.flush()
        self._sink.synchronise()

    def close(self) -> None:
        self._writer.close()
        self._sink.close()
