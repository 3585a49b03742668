"""The flight recorder: messages of the control loop into one MCAP file, without ever making the loop wait.

`log` serialises the message and puts it into a bounded buffer; one thread of the recorder empties the buffer into the
file and hands it to the disk every flush period. A full buffer or a failed disk costs recorded data, never flight:
drops are counted, and recorded as soon as there is room again. No clock is read: messages carry their own time.

Only finished chunks reach the file, so that a killed process leaves everything up to the last flush readable.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any

import foxglove
import orjson
from foxglove import Context
from foxglove.mcap import MCAPCompression, MCAPWriteOptions

from flightapp.config.mission import Mission
from flightapp.config.profile import RecordingOptions
from flightapp.core.errors import InputError
from flightapp.recording import messages
from flightapp.recording.channels import CHANNELS, Channel
from flightapp.recording.schema import encoder_of, encoding_of, schema_of
from flightapp.recording.sink import OpenFile, Sink, create_file
from flightapp.recording.view import View

FILE_PROFILE = "flightapp"
"""Profile in the header of every recording: tells ours from other MCAP files."""
BUFFER_MESSAGES = 8192
BUFFER_LARGE_BYTES = 1 << 25
CLOSE_TIMEOUT_S = 5.0
_DRAINS_A_FLUSH = 4
_BATCH = 64
_EVENT_TOPIC = "/event"
_LARGE_BYTES = 16384
_LOGGER = logging.getLogger(__name__)

_Message = tuple[str, bytes, int]
_Action = Callable[[], None]


class Recorder:
    """Writes one recording. `log` may be called from any thread; it never raises and never waits for the disk.

    channels: what may be logged; those with `logged` False are accepted and not written.
    mission: where given, its fence, boundary and surveyed obstacles are drawn in the view for Foxglove.
    buffer_messages: how many messages wait for the disk before new ones are dropped.
    buffer_large_bytes: how many bytes of large messages (images) wait for the disk before new large ones are dropped.
    open_file: creates the file; replaced in tests by slow and failing ones.
    """

    def __init__(
        self,
        path: Path,
        *,
        channels: tuple[Channel, ...] = CHANNELS,
        options: RecordingOptions | None = None,
        mission: Mission | None = None,
        buffer_messages: int = BUFFER_MESSAGES,
        buffer_large_bytes: int = BUFFER_LARGE_BYTES,
        open_file: OpenFile = create_file,
    ) -> None:
        topics = [channel.topic for channel in channels]
        if len(set(topics)) != len(topics):
            raise ValueError(f"a topic occurs twice: {topics}")
        self.path = path
        self._channels = channels
        self._topics = frozenset(topics)
        self._encoders = {channel.topic: encoder_of(channel.message) for channel in channels}
        self._written = frozenset(channel.topic for channel in channels if channel.logged)
        self._options = options or RecordingOptions()
        self._mission = mission
        self._limit = buffer_messages
        self._large_limit = buffer_large_bytes
        self._large_waiting = 0
        self._open_file = open_file
        self._buffer: SimpleQueue[_Message | _Action] = SimpleQueue()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._sink: Sink | None = None
        self._accepting = False
        self._dropped = 0
        self._dropped_reported = 0
        self._last_ns = 0
        self._error: str | None = None

    @property
    def dropped(self) -> int:
        """Messages that are not in the file although they were logged."""
        return self._dropped

    @property
    def error(self) -> str | None:
        """Why recording stopped, one sentence; None while all is well."""
        return self._error

    def require(self, topics: Iterable[str]) -> None:
        """ValueError unless every one of `topics` is a channel: for start-up, where a misspelt topic belongs."""
        unknown = sorted(set(topics) - self._topics)
        if unknown:
            raise ValueError(f"not recorded channels: {', '.join(unknown)}; known: {', '.join(sorted(self._topics))}")

    def open(self) -> None:
        """Create the file and start writing; InputError if that is not possible. Never overwrites a file."""
        try:
            file = self._open_file(self.path)
        except FileExistsError:
            raise InputError(f"{self.path}: exists already; a recording never overwrites a file") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot be recorded to: {error.strerror}") from None
        self._sink = Sink(file)
        self._thread = threading.Thread(target=self._run, args=(self._sink,), name="recorder", daemon=True)
        self._accepting = True
        self._thread.start()

    def close(self, timeout_s: float = CLOSE_TIMEOUT_S) -> None:
        """Write what is buffered and finish the file; gives up after `timeout_s` if the disk hangs."""
        if self._thread is None:
            return
        self._accepting = False
        self._stop.set()
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            self._fail(f"the disk did not take the rest of the recording within {timeout_s:g} s")
        self._thread = None

    def __enter__(self) -> Recorder:
        self.open()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.close()

    def log(self, topic: str, message: object, t_s: float) -> None:
        """Record `message` (its channel's dataclass) at `t_s` (fleet time, s). Dropped and counted if that is impossible."""
        try:
            if not self._accepting or self._buffer.qsize() >= self._limit or topic not in self._topics:
                self._drop(topic)
            elif topic in self._written:
                payload, time_ns = self._encoders[topic](message), _nanoseconds(t_s)
                if len(payload) < _LARGE_BYTES or self._has_room(len(payload)):
                    self._buffer.put((topic, payload, time_ns))
                else:
                    self._drop(topic)
        except Exception:  # whatever a message contains must not reach the control loop
            self._drop(topic)

    def metadata(self, name: str, mapping: Mapping[str, object]) -> None:
        """Store key-value pairs with the recording: run, versions, mission."""
        texts = {str(key): str(value) for key, value in mapping.items()}
        self._buffer.put(lambda: self._writer.write_metadata(name, texts))

    def attach(self, name: str, path: Path) -> None:
        """Store the file at `path` inside the recording; InputError if it cannot be read."""
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(f"{path}: cannot be attached to the recording: {error.strerror}") from None
        self._buffer.put(lambda: self._attach(name, data))

    def _attach(self, name: str, data: bytes) -> None:
        media_type = "application/toml" if name.endswith(".toml") else "application/octet-stream"
        time_ns = self._last_ns
        self._writer.attach(log_time=time_ns, create_time=time_ns, name=name, media_type=media_type, data=data)

    def _has_room(self, size: int) -> bool:
        """Room for one more large message, then taken. Only large messages take the lock: the control loop sends none."""
        with self._lock:
            fits = self._large_waiting + size <= self._large_limit
            if fits:
                self._large_waiting += size
        return fits

    def _drop(self, topic: str) -> None:
        with self._lock:
            self._dropped += 1
            first = self._dropped == 1
        if first:
            _LOGGER.warning("a message on %s could not be recorded; further drops are counted", topic)

    def _fail(self, reason: str) -> None:
        if self._error is None:
            self._accepting = False
            self._error = f"{self.path}: recording stopped: {reason}"

    def _run(self, sink: Sink) -> None:
        """The recorder's thread: the only one that touches the writer."""
        try:
            self._start(sink)
            drain_s = self._options.flush_period_s / _DRAINS_A_FLUSH
            drains = 0
            while not self._stop.wait(drain_s) and sink.error is None:
                self._drain(sink)
                drains += 1
                if drains % _DRAINS_A_FLUSH == 0:
                    self._report_drops()
                    self._writer.flush()
                    sink.synchronise()
            self._drain(sink)
            self._report_drops()
            if self._dropped:
                self._writer.write_metadata("recording", {"dropped": str(self._dropped)})
            self._writer.close()
            sink.close()
            if sink.error is not None:
                self._fail(sink.error)
        except Exception as error:  # the flight goes on without its recorder
            self._fail(f"{type(error).__name__}: {error}")
        if self._error is not None:
            self._discard()
            _LOGGER.error("%s", self._error)

    def _start(self, sink: Sink) -> None:
        self._context = context = Context()  # kept: channels close with it
        self._raw = {
            channel.topic: foxglove.Channel(
                channel.topic,
                message_encoding=encoding_of(channel.message),
                schema=schema_of(channel.message),
                context=context,
                metadata={"purpose": channel.purpose, "rate_hz": f"{channel.rate_hz:g}"},
            )
            for channel in self._channels
            if channel.logged
        }
        self._view: View | None = View(context, self._mission)
        self._writer: Any = foxglove.open_mcap(
            sink,
            context=context,
            writer_options=MCAPWriteOptions(
                compression=MCAPCompression.Lz4,
                profile=FILE_PROFILE,
                chunk_size=self._options.chunk_bytes,
                disable_seeking=True,
            ),
        )

    def _drain(self, sink: Sink) -> None:
        """Write what is buffered, in batches between which the interpreter is free for the control loop."""
        while sink.error is None:
            for _ in range(_BATCH):
                try:
                    item = self._buffer.get_nowait()
                except Empty:
                    return
                if callable(item):
                    item()
                else:
                    topic, payload, self._last_ns = item
                    self._raw[topic].log(payload, log_time=self._last_ns)
                    self._feed_view(topic, payload, self._last_ns)
                    if len(payload) >= _LARGE_BYTES:
                        with self._lock:
                            self._large_waiting -= len(payload)
                        break
            self._stop.wait(0.0005)

    def _feed_view(self, topic: str, payload: bytes, time_ns: int) -> None:
        """The view is a convenience: a message that it cannot draw ends the view, not the recording."""
        if self._view is not None:
            try:
                self._view.feed(topic, payload, time_ns)
            except Exception:
                self._view = None
                _LOGGER.exception("a message on %s cannot be drawn; this recording goes on without a view", topic)

    def _report_drops(self) -> None:
        count = self._dropped
        if count == self._dropped_reported or _EVENT_TOPIC not in self._raw:
            return
        new = count - self._dropped_reported
        event = messages.Event(
            t_s=self._last_ns * 1e-9,
            level="warning",
            name="recording-dropped",
            text=f"{new} messages could not be recorded, {count} in all",
            data={"new": new, "total": count},
        )
        self._raw[_EVENT_TOPIC].log(orjson.dumps(event), log_time=self._last_ns)
        self._dropped_reported = count

    def _discard(self) -> None:
        """Count what will never be written."""
        while True:
            try:
                item = self._buffer.get_nowait()
            except Empty:
                return
            if not callable(item):
                with self._lock:
                    self._dropped += 1


def _nanoseconds(t_s: float) -> int:
    """Fleet time as the file stores it; ValueError outside its range."""
    time_ns = int(t_s * 1e9)
    if not 0 <= time_ns < 1 << 63:
        raise ValueError(f"{t_s} s is not a time")
    return time_ns
