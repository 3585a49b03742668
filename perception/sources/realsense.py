"""An Intel RealSense camera; the SDK's software device runs through the same code."""

from __future__ import annotations

import atexit
import threading
from collections.abc import Callable
from typing import Any

from perception.sources.api import SourceHealth
from perception.sources.clock_mapping import CaptureClock
from perception.sources.frame_copies import FrameCopies
from perception.sources.inbox import Arrival, Inbox
from perception.sources.realsense_device import CameraFinder
from perception.sources.realsense_sdk import import_sdk
from perception.sources.realsense_stream import DepthMode, DepthStream
from perception.sources.stall_watch import StallWatch
from perception.types import DepthFrame

_WATCH_PERIOD_S = 0.1
_TEMPERATURE_PERIOD_S = 1.0
_CLOSE_TIMEOUT_S = 2.0


class RealSenseSource:
    """Depth of one RealSense camera.

    now_s: the caller's time; unix_s: the host's Unix time, in which the SDK may stamp frames. find_device: the SDK's device,
    asked for again whenever the stream has stalled. mode: None takes the first that the device has. PerceptionInputError if the
    SDK or the device is missing or does not offer the mode. A camera that falls silent later is started again by a thread of
    the source's own, for as long as it takes; meanwhile `latest()` is None and `health.fault` says why.
    """

    def __init__(
        self,
        *,
        now_s: Callable[[], float],
        unix_s: Callable[[], float],
        find_device: Callable[[], Any],
        mode: DepthMode | None = None,
        stall_timeout_s: float = 1.0,
        emitter: bool | None = None,
    ) -> None:
        self._rs = import_sdk()
        self._now_s = now_s
        self._unix_s = unix_s
        self._find_device = find_device
        self._mode = mode
        self._emitter = emitter
        self._clock = CaptureClock()
        self._inbox = Inbox(is_lossless=False)
        self._copies = FrameCopies()
        self._temperature_c: float | None = None
        self._stopping = threading.Event()
        self._stream = self._start()
        self._watch = StallWatch(self._stream.label, self._start_again, stall_timeout_s=stall_timeout_s, started_s=now_s())
        self._watcher = threading.Thread(target=self._watch_over, name="realsense-watch", daemon=True)
        # The SDK's thread must not call into an interpreter that is being taken down.
        atexit.register(self.close)
        self._watcher.start()

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(
            received=self._copies.count,
            skipped=self._inbox.skipped,
            lost=self._inbox.lost,
            restarts=self._watch.restarts,
            temperature_c=self._temperature_c,
            fault=self._watch.fault(self._inbox.arrived),
            warning=self._stream.warning,
        )

    @property
    def is_finished(self) -> bool:
        return False

    def latest(self) -> DepthFrame | None:
        arrival = self._inbox.take()
        return None if arrival is None else self._copies.take(arrival, self._stream.depth_unit_m)

    def close(self) -> None:
        if self._stopping.is_set():
            return
        atexit.unregister(self.close)
        self._stopping.set()
        self._inbox.close()
        # The SDK can hang on a device that is gone, and the watcher in it: then the process ends without it.
        self._watcher.join(_CLOSE_TIMEOUT_S)

    def _start(self) -> DepthStream:
        stream = DepthStream(self._rs, self._find_device(), self._mode, emitter=self._emitter)
        stream.start(lambda frame: self._deliver(stream, frame))
        return stream

    def _start_again(self) -> None:
        self._stream.stop()
        self._clock.reset()
        self._inbox.forget_number()
        self._stream = self._start()

    def _deliver(self, stream: DepthStream, frame: Any) -> None:
        arrival_s, unix_s = self._now_s(), self._unix_s()
        stamp_s, is_unix = stream.stamp(frame)
        t_s = self._clock.capture_s(stamp_s, arrival_s, unix_s - stamp_s if is_unix else None)
        self._inbox.put(Arrival(frame, int(frame.get_frame_number()), t_s))

    def _watch_over(self) -> None:
        next_reading_s = self._now_s()
        while not self._stopping.wait(_WATCH_PERIOD_S):
            now_s = self._now_s()
            self._watch.step(now_s, self._inbox.arrived)
            if now_s >= next_reading_s and not self._watch.fault(self._inbox.arrived):
                next_reading_s = now_s + _TEMPERATURE_PERIOD_S
                self._temperature_c = self._stream.temperature_c()
        self._stream.stop()


def open_camera(
    *,
    now_s: Callable[[], float],
    unix_s: Callable[[], float],
    mode: DepthMode,
    serial_number: str | None = None,
    stall_timeout_s: float = 1.0,
    emitter: bool | None = None,
) -> RealSenseSource:
    """The connected camera with that serial number, or the only one there is; PerceptionInputError as `RealSenseSource`."""
    return RealSenseSource(
        now_s=now_s,
        unix_s=unix_s,
        find_device=CameraFinder(import_sdk(), serial_number),
        mode=mode,
        stall_timeout_s=stall_timeout_s,
        emitter=emitter,
    )
