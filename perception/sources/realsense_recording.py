"""A recording of a RealSense camera, played by the SDK through the camera's own code."""

from __future__ import annotations

import atexit
import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from perception.sources.api import SourceHealth
from perception.sources.clock_mapping import CaptureClock
from perception.sources.frame_copies import FrameCopies
from perception.sources.inbox import Arrival, Inbox
from perception.sources.realsense_device import load_recording
from perception.sources.realsense_sdk import import_sdk
from perception.sources.realsense_stream import DepthStream
from perception.sources.stall_watch import START_TIMEOUT_S
from perception.types import DepthFrame


class RealSenseRecordingSource:
    """A recording (.db3, older .bag) of a RealSense camera.

    is_real_time: frames come at the pace they were recorded, the newest wins and they count as taken now, as of a camera.
    Otherwise every frame comes, one a call, and times count from the first one. PerceptionInputError if the SDK or the file is
    missing, or the file is cut short or foreign.
    """

    def __init__(self, path: Path, *, now_s: Callable[[], float], is_real_time: bool = False) -> None:
        rs = import_sdk()
        self._now_s = now_s
        self._is_real_time = is_real_time
        self._clock = CaptureClock()
        self._first_stamp_s: float | None = None
        self._inbox = Inbox(is_lossless=not is_real_time)
        self._copies = FrameCopies()
        self._is_finished = False
        self._is_closed = False
        self._playback = load_recording(rs, path, is_real_time=is_real_time)
        self._stopped = rs.playback_status.stopped
        self._path = path
        self._stream = DepthStream(rs, self._playback, None, name=str(path))
        self._started_s = now_s()
        # The SDK's thread must not call into an interpreter that is being taken down.
        atexit.register(self.close)
        self._stream.start(self._deliver)

    @property
    def health(self) -> SourceHealth:
        is_empty = self._is_finished and self._inbox.arrived == 0
        fault = f"{self._path}: holds no depth frame" if is_empty else ""
        return SourceHealth(received=self._copies.count, skipped=self._inbox.skipped, lost=self._inbox.lost, fault=fault)

    @property
    def is_finished(self) -> bool:
        return self._is_finished

    def latest(self) -> DepthFrame | None:
        if self._is_finished:
            return None
        is_at_end = self._is_at_end()
        arrival = self._inbox.take()
        if arrival is None:
            self._is_finished = is_at_end
            return None
        return self._copies.take(arrival, self._stream.depth_unit_m)

    def close(self) -> None:
        if self._is_closed:
            return
        atexit.unregister(self.close)
        self._is_closed = self._is_finished = True
        self._inbox.close()
        # The SDK's reader must rest before its device goes: it outlives the device otherwise, and crashes (SDK 2.59.1).
        with contextlib.suppress(RuntimeError):
            self._playback.pause()
        self._stream.stop()

    def _is_at_end(self) -> bool:
        """Asked before the inbox: the last frame is delivered before the playback stops. It also counts as stopped at first."""
        is_stopped = self._playback.current_status() == self._stopped
        return bool(is_stopped) and (self._inbox.arrived > 0 or self._now_s() - self._started_s > START_TIMEOUT_S)

    def _deliver(self, frame: Any) -> None:
        stamp_s, _ = self._stream.stamp(frame)
        if self._first_stamp_s is None:
            self._first_stamp_s = stamp_s
        t_s = self._clock.capture_s(stamp_s, self._now_s()) if self._is_real_time else stamp_s - self._first_stamp_s
        self._inbox.put(Arrival(frame, int(frame.get_frame_number()), t_s))
