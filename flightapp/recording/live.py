"""The live view: the topics of the recording over a WebSocket that Foxglove and Lichtblick open (`foxglove.sdk.v1`)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import foxglove
from foxglove import Context
from foxglove.websocket import WebSocketServer

from flightapp.core.errors import InputError
from flightapp.recording.channels import Channel

PORT = 8765
"""The port that Foxglove proposes."""
ADDRESS = "127.0.0.1"
BACKLOG_MESSAGES = 1024
"""Kept for each client; of a client that is too slow the oldest go."""


@dataclass(frozen=True, slots=True)
class LiveView:
    """Where to serve: port 0 takes any free one; the address decides who can connect."""

    port: int = PORT
    address: str = ADDRESS

    def start(self, context: Context, channels: tuple[Channel, ...], name: str) -> WebSocketServer:
        """Serve what is logged in `context`, from threads of the library's own; InputError if the port cannot be had."""
        topics = frozenset(channel.topic for channel in channels if channel.live)
        try:
            return foxglove.start_server(
                name=name,
                host=self.address,
                port=self.port,
                context=context,
                channel_filter=lambda channel: channel.topic in topics,
                message_backlog_size=BACKLOG_MESSAGES,
            )
        except Exception as error:  # the library has an exception class of its own for each of its troubles
            raise InputError(
                f"--live: {self.address}:{self.port}: cannot be served: {error}; name a free port, or 0 for any"
            ) from None

    def url(self, server: WebSocketServer) -> str:
        return f"ws://{self.address}:{server.port}"


@contextmanager
def url_told(folder: Path, vehicle: str, url: str) -> Iterator[None]:
    """While the context lasts, the run's folder says where the live view is, for whoever started the vehicle's process."""
    file, temporary = url_file(folder, vehicle), folder / f".{vehicle}.live.tmp"
    temporary.write_text(url + "\n")
    temporary.replace(file)
    try:
        yield
    finally:
        file.unlink(missing_ok=True)


def url_file(folder: Path, vehicle: str) -> Path:
    """The file that holds the address of the vehicle's live view."""
    return folder / f"{vehicle}.live"
