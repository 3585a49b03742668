"""The decimated log beside a recording: all events, states now and then; small enough to send over a phone."""

from __future__ import annotations

import math

from foxglove import Context

from flightapp.recording.channels import Channel
from flightapp.recording.mcap_output import McapOutput, outlets_of
from flightapp.recording.sink import Sink

SUFFIX = ".small.mcap"
CHUNK_BYTES = 262144
FLUSH_PERIOD_NS = 5_000_000_000
"""Of recorded time. Seldom, because short chunks compress badly; the recording itself is what a crash must not cost."""
_EARLY = 0.05
"""Share of its period by which a message may come early: rates are those of a loop that is never quite even."""


class SmallLog:
    """Takes every message of the recording and writes those that are due. Belongs to the recorder's thread."""

    def __init__(self, channels: tuple[Channel, ...], sink: Sink) -> None:
        kept = tuple(channel for channel in channels if channel.small_hz > 0.0 and channel.logged)
        self._context = Context()
        self._outlets = outlets_of(self._context, kept)
        self._output = McapOutput(self._context, frozenset(self._outlets), sink, CHUNK_BYTES)
        self._periods_ns = {channel.topic: _period_ns(channel.small_hz) for channel in kept}
        self._due_ns = dict.fromkeys(self._outlets, 0)
        self._flush_due_ns = 0

    @property
    def error(self) -> str | None:
        return self._output.error

    def offer(self, topic: str, payload: bytes, time_ns: int) -> None:
        """Write the message if its channel's turn has come."""
        due_ns = self._due_ns.get(topic)
        if due_ns is not None and time_ns >= due_ns:
            self._outlets[topic](payload, time_ns)
            self._due_ns[topic] = time_ns + self._periods_ns[topic]

    def metadata(self, name: str, texts: dict[str, str]) -> None:
        self._output.metadata(name, texts)

    def attach(self, name: str, data: bytes, time_ns: int) -> None:
        self._output.attach(name, data, time_ns)

    def flush(self, now_ns: int) -> None:
        """Hand it to the disk where that is due."""
        if now_ns >= self._flush_due_ns:
            self._flush_due_ns = now_ns + FLUSH_PERIOD_NS
            self._output.flush()

    def close(self) -> None:
        self._output.close()


def _period_ns(rate_hz: float) -> int:
    return 0 if math.isinf(rate_hz) else round(1e9 * (1.0 - _EARLY) / rate_hz)
