"""A client of the live view, as Foxglove is one: sub-protocol foxglove.sdk.v1 over a real WebSocket."""

from __future__ import annotations

import json
import struct
from contextlib import ExitStack
from types import TracebackType
from typing import Any

from websockets.sync.client import connect
from websockets.typing import Subprotocol

PROTOCOL = Subprotocol("foxglove.sdk.v1")
_MESSAGE_DATA = 1
_HEADER = struct.Struct("<BIQ")
"""Of message data: opcode, subscription, time in ns."""


class LiveClient:
    """Connects, subscribes to what is advertised, and takes messages."""

    def __init__(self, url: str, timeout_s: float = 10.0) -> None:
        self._timeout_s = timeout_s
        self._open = ExitStack()
        self._socket = self._open.enter_context(connect(url, subprotocols=[PROTOCOL], open_timeout=timeout_s))
        self.channels: dict[str, dict[str, Any]] = {}
        self.server: dict[str, Any] = {}
        self._topics: dict[int, str] = {}

    def __enter__(self) -> LiveClient:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self._open.close()

    def advertised(self, topics: set[str]) -> None:
        """Wait until all of `topics` are offered; TimeoutError if they are not."""
        while not topics <= set(self.channels):
            self._note(self._socket.recv(self._timeout_s))

    def subscribe(self) -> None:
        """To everything that is offered."""
        wishes = [{"id": channel["id"], "channelId": channel["id"]} for channel in self.channels.values()]
        self._topics = {channel["id"]: topic for topic, channel in self.channels.items()}
        self._socket.send(json.dumps({"op": "subscribe", "subscriptions": wishes}))

    def message(self, timeout_s: float = 10.0) -> tuple[str, int, bytes]:
        """Topic, time in ns and bytes of the next message; TimeoutError if none comes."""
        while True:
            frame = self._socket.recv(timeout_s)
            if isinstance(frame, bytes) and frame[0] == _MESSAGE_DATA:
                _, number, time_ns = _HEADER.unpack_from(frame)
                return self._topics[number], time_ns, frame[_HEADER.size :]
            self._note(frame)

    def _note(self, frame: str | bytes) -> None:
        if isinstance(frame, str):
            content = json.loads(frame)
            if content["op"] == "serverInfo":
                self.server = content
            elif content["op"] == "advertise":
                self.channels.update({channel["topic"]: channel for channel in content["channels"]})
