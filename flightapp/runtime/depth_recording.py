"""Depth images into the recording, beside perception: it hands frames over and never waits for their compression."""

from __future__ import annotations

import logging
import math
import os
import threading
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from flightapp.config.profile import RecordingOptions
from flightapp.recording import depth
from flightapp.recording.recorder import Recorder
from flightapp.vehicle.autopilot import Motion
from flightapp.vehicle.pose_history import PoseHistory
from perception.sources import DepthSource, SourceHealth
from perception.types import DepthFrame

CLOSE_TIMEOUT_S = 1.0
EARLY_SHARE = 0.25
"""A frame this part of a period before it is due is taken: cameras are not exactly punctual."""
TELEMETRY_RETRY_S, TELEMETRY_ATTEMPTS = 0.005, 20
_LOGGER = logging.getLogger(__name__)


class Pace:
    """Which of a camera's frames are due at a lower rate; evenly, although a frame is never exactly on time."""

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._due_s = -math.inf

    def is_due(self, t_s: float) -> bool:
        """Whether the frame of `t_s` is to be kept; a clock that jumps starts the beat anew."""
        late_s = t_s - self._due_s
        if -2.0 * self._period_s < late_s < -EARLY_SHARE * self._period_s:
            return False
        self._due_s = (self._due_s if abs(late_s) < self._period_s else t_s) + self._period_s
        return True


class DepthRecording:
    """Thins and keeps the newest frame that is due; a thread of its own compresses and records it.

    The slot holds one frame: a newer one replaces it, and the older one is counted in `dropped`.
    compress: from pixels to bytes, without the interpreter lock; replaced in tests by one that hangs.
    """

    def __init__(
        self,
        recorder: Recorder,
        history: PoseHistory,
        camera: depth.DepthCamera,
        options: RecordingOptions,
        compress: Callable[[NDArray[np.uint16]], bytes] = depth.png,
    ) -> None:
        recorder.require((depth.IMAGE, depth.CALIBRATION, depth.INFO))
        self._recorder = recorder
        self._history = history
        self._camera = camera
        self._stride = options.depth_stride
        self._pace = Pace(options.depth_rate_hz)
        self._compress = compress
        self._change = threading.Condition()
        self._waiting: DepthFrame | None = None
        self._closing = False
        self._dropped = 0
        self._thread = threading.Thread(target=self._run, name="depth recording", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Frames that were due but never compressed."""
        return self._dropped

    def offer(self, frame: DepthFrame) -> None:
        """Keep `frame` if one is due; never raises, costs at most a copy of its pixels, which belong to the camera."""
        if frame.depth.ndim != 2 or not math.isfinite(frame.t_s) or not self._pace.is_due(frame.t_s):
            return
        kept = depth.thinned(frame, self._stride)
        with self._change:
            self._dropped += self._waiting is not None
            self._waiting = kept
            self._change.notify()

    def close(self) -> None:
        """Record what is waiting and end; gives up on a compression that hangs."""
        with self._change:
            self._closing = True
            self._change.notify()
        self._thread.join(CLOSE_TIMEOUT_S)

    def _run(self) -> None:
        _yield_to_others()
        while (frame := self._take()) is not None:
            try:
                self._record(frame)
            except Exception as error:  # one lost picture; perception and flight go on
                with self._change:
                    self._dropped += 1
                    first = self._dropped == 1
                if first:
                    _LOGGER.warning("a depth image could not be recorded: %s; further ones are counted", error)

    def _take(self) -> DepthFrame | None:
        """The waiting frame, as soon as there is one; None at the end."""
        with self._change:
            self._change.wait_for(lambda: self._waiting is not None or self._closing)
            frame, self._waiting = self._waiting, None
            return frame

    def _record(self, frame: DepthFrame) -> None:
        data = self._compress(frame.depth)
        motion = self._motion_at(frame.t_s)
        info = depth.info_message(frame, self._stride, motion, self._camera, self._dropped)
        self._recorder.log(depth.INFO, info, frame.t_s)
        self._recorder.log(depth.CALIBRATION, depth.calibration_message(frame), frame.t_s)
        self._recorder.log(depth.IMAGE, depth.image_message(frame, data), frame.t_s)

    def _motion_at(self, t_s: float) -> Motion | None:
        """Of the capture time, for which the telemetry after it is awaited: interpolated, not extrapolated."""
        for _ in range(TELEMETRY_ATTEMPTS):
            if not -math.inf < self._history.newest_s < t_s or self._closing:
                break
            with self._change:
                self._change.wait(TELEMETRY_RETRY_S)
        return self._history.at(t_s)


class RecordedSource:
    """A depth source whose frames are also offered to a recording; it belongs to the source and closes with it."""

    def __init__(self, source: DepthSource, recording: DepthRecording) -> None:
        self._source = source
        self._recording = recording

    @property
    def health(self) -> SourceHealth:
        return self._source.health

    @property
    def is_finished(self) -> bool:
        return self._source.is_finished

    def latest(self) -> DepthFrame | None:
        frame = self._source.latest()
        if frame is not None:
            self._recording.offer(frame)
        return frame

    def close(self) -> None:
        self._recording.close()
        self._source.close()


def _yield_to_others() -> None:
    """This thread never takes the processor from one that runs.

    It keeps its share: a thread of low priority that is set aside while it holds the interpreter lock would hold up the
    control loop.
    """
    with suppress(AttributeError, OSError):
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
