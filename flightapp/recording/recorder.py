"""The flight recorder: messages of the control loop into one MCAP file, without ever making the loop wait.

`log` puts the message into a bounded backlog. One thread of the recorder serialises it, writes it to the file, draws the
view, feeds the small log and the live view, and hands all to the disk every flush period. A slow, full or failed disk costs
recorded data, the cheapest channels first, never flight: drops are counted by channel, and recorded as soon as there is
room. Messages carry their own time; the only clock that is read measures how long a flush takes.
"""

from __future__ import annotations

import logging
import os
import shutil
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import TracebackType

import orjson
from foxglove import Context
from foxglove.websocket import WebSocketServer

from flightapp.config.mission import Mission
from flightapp.config.profile import RecordingOptions
from flightapp.core.clock import monotonic_ns
from flightapp.core.errors import InputError
from flightapp.recording import messages
from flightapp.recording.backlog import Backlog
from flightapp.recording.channels import CHANNELS, Channel
from flightapp.recording.live import LiveView
from flightapp.recording.mcap_output import FILE_PROFILE, McapOutput, outlets_of
from flightapp.recording.schema import encoder_of, is_foxglove
from flightapp.recording.sink import OpenFile, Sink, create_file
from flightapp.recording.small_log import SmallLog
from flightapp.recording.view import View

__all__ = ["FILE_PROFILE", "Recorder"]

BUFFER_MESSAGES = 8192
BUFFER_LARGE_BYTES = 1 << 25
CLOSE_TIMEOUT_S = 5.0
_DRAINS_A_FLUSH = 4
_BATCH = 16
_PAUSE_S = 0.0005
_EVENT_TOPIC = "/event"
_LARGE_BYTES = 16384
_LOGGER = logging.getLogger(__name__)

_Message = tuple[str, object, int]
_Action = Callable[[], None]


def free_bytes_at(path: Path) -> int:
    """Free space on the disk of `path`."""
    return shutil.disk_usage(path.parent).free


class Recorder:
    """Writes one recording. `log` may be called from any thread; it never raises and never waits for the disk.

    channels: what may be logged; those with neither `logged` nor `live` are accepted and go nowhere.
    mission: where given, its fence, boundary and surveyed obstacles are drawn in the view for Foxglove.
    small_path: where given, a decimated log is written there too.
    live: where given, the same topics are served over a WebSocket; `live_url` tells where.
    buffer_messages: how many messages wait for the disk before new ones are dropped.
    buffer_large_bytes: how many bytes of large messages (images) wait for the disk before new large ones are dropped.
    open_file: creates the file; free_bytes: of its disk. Both are replaced in tests by slow, full and failing disks.
    """

    def __init__(
        self,
        path: Path,
        *,
        channels: tuple[Channel, ...] = CHANNELS,
        options: RecordingOptions | None = None,
        mission: Mission | None = None,
        small_path: Path | None = None,
        live: LiveView | None = None,
        buffer_messages: int = BUFFER_MESSAGES,
        buffer_large_bytes: int = BUFFER_LARGE_BYTES,
        open_file: OpenFile = create_file,
        free_bytes: Callable[[Path], int] = free_bytes_at,
    ) -> None:
        topics = [channel.topic for channel in channels]
        if len(set(topics)) != len(topics):
            raise ValueError(f"a topic occurs twice: {topics}")
        self.path = path
        self.live_url: str | None = None
        self._channels = channels
        self._topics = frozenset(topics)
        self._encoders = {channel.topic: encoder_of(channel.message) for channel in channels}
        self._binary = frozenset(channel.topic for channel in channels if is_foxglove(channel.message))
        self._used = tuple(channel for channel in channels if channel.logged or channel.live)
        self._used_topics = frozenset(channel.topic for channel in self._used)
        self._options = options or RecordingOptions()
        self._mission = mission
        self._small_path = small_path
        self._live = live
        self._open_file = open_file
        self._free_bytes = free_bytes
        self._backlog: Backlog[_Message | _Action] = Backlog(channels, buffer_messages, buffer_large_bytes)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._server: WebSocketServer | None = None
        self._small: SmallLog | None = None
        self._accepting = False
        self._dropped_reported = 0
        self._last_ns = 0
        self._flush_slowest_s = 0.0
        self._error: str | None = None

    @property
    def dropped(self) -> int:
        """Messages that are not in the file although they were logged."""
        return self._backlog.dropped

    @property
    def drops(self) -> Mapping[str, int]:
        """The same, by topic."""
        return self._backlog.drops

    @property
    def flush_slowest_s(self) -> float:
        """Longest time that handing the recording to the disk has taken so far."""
        return self._flush_slowest_s

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
        """Create the files, start serving and writing; InputError if that is not possible. Never overwrites a file."""
        self._context = Context()  # kept: channels close with it
        if self._live is not None:
            self._server = self._live.start(self._context, self._channels, self.path.stem)
            self.live_url = self._live.url(self._server)
        try:
            sink = self._create(self.path)
            small = None if self._small_path is None else self._create(self._small_path)
        except InputError:
            self._stop_serving()
            raise
        self._thread = threading.Thread(target=self._run, args=(sink, small), name="recorder", daemon=True)
        self._accepting = True
        self._thread.start()

    def _create(self, path: Path) -> Sink:
        try:
            return Sink(self._open_file(path))
        except FileExistsError:
            raise InputError(f"{path}: exists already; a recording never overwrites a file") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be recorded to: {error.strerror}") from None

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
        self._stop_serving()

    def abandon(self) -> None:
        """As `close`, without what is buffered: the end of a run that nobody reads."""
        self._accepting = False
        while self._backlog.take() is not None:
            pass
        self.close()

    def _stop_serving(self) -> None:
        if self._server is not None:
            self._server.stop()
            self._server = None

    def __enter__(self) -> Recorder:
        self.open()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.close()

    def log(self, topic: str, message: object, t_s: float) -> None:
        """Record `message` at `t_s` (fleet time, s). Dropped and counted if that is impossible.

        message: of its channel's type, or a function that makes one. Both are serialised later, in the recorder's thread:
        nothing that they refer to may change after the call. Foxglove's own messages are serialised at once.
        """
        try:
            if not self._accepting or topic not in self._topics:
                self._backlog.drop(topic)
            elif topic not in self._used_topics:
                return
            elif not self._backlog.admits(topic):
                self._backlog.drop(topic)
            elif topic in self._binary:
                self._put_binary(topic, message, _nanoseconds(t_s))
            else:
                self._backlog.put((topic, message, _nanoseconds(t_s)))
        except Exception:  # whatever a message contains must not reach the control loop
            self._backlog.drop(topic)

    def _put_binary(self, topic: str, message: object, time_ns: int) -> None:
        """An image is serialised by the thread that made it, which is not the control loop's."""
        payload = self._encoders[topic](message)
        if len(payload) < _LARGE_BYTES or self._backlog.reserve(len(payload)):
            self._backlog.put((topic, payload, time_ns))
        else:
            self._backlog.drop(topic)

    def metadata(self, name: str, mapping: Mapping[str, object]) -> None:
        """Store key-value pairs with the recording: run, versions, mission."""
        texts = {str(key): str(value) for key, value in mapping.items()}
        self._backlog.put(lambda: self._write_metadata(name, texts))

    def attach(self, name: str, path: Path) -> None:
        """Store the file at `path` inside the recording; InputError if it cannot be read."""
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(f"{path}: cannot be attached to the recording: {error.strerror}") from None
        self._backlog.put(lambda: self._attach(name, data))

    def _write_metadata(self, name: str, texts: dict[str, str]) -> None:
        self._output.metadata(name, texts)
        if self._small is not None:
            self._small.metadata(name, texts)

    def _attach(self, name: str, data: bytes) -> None:
        self._output.attach(name, data, self._last_ns)
        if self._small is not None:
            self._small.attach(name, data, self._last_ns)

    def _fail(self, reason: str) -> None:
        if self._error is None:
            self._accepting = False
            self._error = f"{self.path}: recording stopped: {reason}"

    def _run(self, sink: Sink, small: Sink | None) -> None:
        """The recorder's thread: the only one that touches the files."""
        try:
            self._start(sink, small)
            drain_s = self._options.flush_period_s / _DRAINS_A_FLUSH
            drains = 0
            while not self._stop.wait(drain_s) and self._output.error is None:
                self._drain()
                drains += 1
                if drains % _DRAINS_A_FLUSH == 0:
                    self._report_drops()
                    self._flush()
            self._drain()
            self._report_drops()
            if self.dropped:
                self._write_metadata("recording", {"dropped": str(self.dropped), **_texts(self.drops)})
            self._output.close()
            if self._small is not None:
                self._small.close()
            if self._output.error is not None:
                self._fail(self._output.error)
        except Exception as error:  # the flight goes on without its recorder
            self._fail(f"{type(error).__name__}: {error}")
        if self._error is not None:
            self._discard()
            _LOGGER.error("%s", self._error)

    def _start(self, sink: Sink, small: Sink | None) -> None:
        self._outlets = outlets_of(self._context, self._used)
        logged = frozenset(channel.topic for channel in self._used if channel.logged)
        self._output = McapOutput(self._context, logged, sink, self._options.chunk_bytes)
        self._small = None if small is None else SmallLog(self._channels, small)
        self._view: View | None = View(self._draw, self._is_drawn, self._mission)

    def _drain(self) -> None:
        """Write what is buffered. Between messages the interpreter is free for the control loop."""
        count = 0
        while self._output.error is None:
            item = self._backlog.take()
            if item is None:
                return
            if callable(item):
                item()
            else:
                self._write(*item)
            count += 1
            if count % _BATCH == 0:
                self._stop.wait(_PAUSE_S)
            else:
                os.sched_yield()

    def _write(self, topic: str, message: object, time_ns: int) -> None:
        """One message into everything that wants it."""
        if isinstance(message, bytes):
            payload = message
            if len(payload) >= _LARGE_BYTES:
                self._backlog.release(len(payload))
        else:
            try:
                payload = self._encoders[topic](message() if callable(message) else message)
            except Exception:  # whatever a message contains must not end the recording
                self._backlog.drop(topic)
                return
        self._last_ns = time_ns
        self._emit(topic, payload, time_ns)
        self._feed_view(topic, payload, time_ns)

    def _emit(self, topic: str, payload: bytes, time_ns: int) -> None:
        self._outlets[topic](payload, time_ns)
        if self._small is not None:
            self._small.offer(topic, payload, time_ns)

    def _feed_view(self, topic: str, payload: bytes, time_ns: int) -> None:
        """The view is a convenience: a message that it cannot draw ends the view, not the recording."""
        if self._view is not None:
            try:
                self._view.feed(topic, payload, time_ns)
            except Exception:
                self._view = None
                _LOGGER.exception("a message on %s cannot be drawn; this recording goes on without a view", topic)

    def _is_drawn(self, topic: str) -> bool:
        """Whether the view may draw on `topic` now; counted as dropped where the disk is too slow or too full for it."""
        if topic not in self._used_topics:
            return False
        admitted = self._backlog.admits(topic)
        if not admitted:
            self._backlog.drop(topic)
        return admitted

    def _draw(self, topic: str, message: object, time_ns: int) -> None:
        self._emit(topic, self._encoders[topic](message), time_ns)

    def _flush(self) -> None:
        """Hand everything to the disk, and see how long it takes and how much room is left."""
        started_ns = monotonic_ns()
        self._output.flush()
        self._flush_slowest_s = max(self._flush_slowest_s, (monotonic_ns() - started_ns) * 1e-9)
        try:
            self._backlog.note_free(self._free_bytes(self.path))
        except OSError as error:
            _LOGGER.warning("free space for %s is not known: %s", self.path, error)
        if self._small is not None:
            self._small.flush(self._last_ns)
            if self._small.error is not None:
                _LOGGER.warning("%s: the small log ends: %s", self._small_path, self._small.error)
                self._small = None

    def _report_drops(self) -> None:
        drops = self.drops
        count = sum(drops.values())
        if count == self._dropped_reported or _EVENT_TOPIC not in self._used_topics:
            return
        new = count - self._dropped_reported
        event = messages.Event(
            t_s=self._last_ns * 1e-9,
            level="warning",
            name="recording-dropped",
            text=f"{new} messages could not be recorded, {count} in all",
            data={"new": new, "total": count, "channels": drops},
        )
        self._emit(_EVENT_TOPIC, orjson.dumps(event), self._last_ns)
        self._dropped_reported = count

    def _discard(self) -> None:
        """Count what will never be written."""
        while (item := self._backlog.take()) is not None:
            if not callable(item):
                self._backlog.drop(item[0])


def _texts(drops: Mapping[str, int]) -> dict[str, str]:
    return {f"dropped {topic}": str(count) for topic, count in sorted(drops.items())}


def _nanoseconds(t_s: float) -> int:
    """Fleet time as the file stores it; ValueError outside its range."""
    time_ns = int(t_s * 1e9)
    if not 0 <= time_ns < 1 << 63:
        raise ValueError(f"{t_s} s is not a time")
    return time_ns
