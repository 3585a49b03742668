"""Intel RealSense through librealsense. The SDK is imported when a source is made: without a camera nobody needs it.

A recording (`.db3`) plays through the same code as a camera.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from perception.errors import PerceptionInputError
from perception.sources.api import SourceHealth
from perception.sources.clock_mapping import CaptureClock
from perception.types import DepthFrame, Intrinsics


class RealSenseSource:
    """Depth of one RealSense camera, or of a recording of one.

    now_s: the caller's time; unix_s: the host's Unix time, in which the SDK stamps frames. Raises PerceptionInputError if the
    SDK or the camera is missing or the camera does not offer the mode. A camera that stops delivering (unplugged) shows as
    None from `latest()` and a sentence in `health.fault`.
    """

    def __init__(
        self,
        *,
        now_s: Callable[[], float],
        unix_s: Callable[[], float],
        width_px: int = 848,
        height_px: int = 480,
        rate_hz: float = 30.0,
        serial_number: str | None = None,
        recording: Path | None = None,
    ) -> None:
        self._rs = _import_sdk()
        self._clock = CaptureClock(now_s, unix_s)
        self._number: int | None = None
        self._received = 0
        self._skipped = 0
        self._fault = ""
        self._is_recording = recording is not None
        self._pipeline = self._rs.pipeline()
        config = self._rs.config()
        if recording is not None:
            if not recording.is_file():
                raise PerceptionInputError(f"{recording}: no such recording; a .db3 file of the RealSense SDK is wanted")
            config.enable_device_from_file(str(recording), repeat_playback=False)
            config.enable_stream(self._rs.stream.depth)
        else:
            if serial_number is not None:
                config.enable_device(serial_number)
            config.enable_stream(self._rs.stream.depth, width_px, height_px, self._rs.format.z16, round(rate_hz))
        try:
            profile = self._pipeline.start(config)
        except RuntimeError as error:
            camera = f"camera {serial_number}" if serial_number is not None else "camera"
            what = str(recording) if recording is not None else f"RealSense {camera}, {width_px}x{height_px} at {rate_hz:g} Hz"
            raise PerceptionInputError(f"{what}: cannot be started: {error}; check that it is plugged in (USB 3)") from None
        if recording is not None:
            profile.get_device().as_playback().set_real_time(False)
        self._depth_unit_m = float(profile.get_device().first_depth_sensor().get_depth_scale())
        self._buffers = [np.zeros((height_px, width_px), np.uint16) for _ in range(2)]

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(received=self._received, skipped=self._skipped, fault=self._fault)

    @property
    def is_finished(self) -> bool:
        return self._is_recording and bool(self._fault)

    def latest(self) -> DepthFrame | None:
        newest = self._poll()
        if newest is None:
            return None
        number = int(newest.get_frame_number())
        if self._number is not None:
            if number <= self._number:
                return None
            self._skipped += number - self._number - 1
        self._number = number
        video = newest.get_profile().as_video_stream_profile().get_intrinsics()
        intrinsics = Intrinsics(video.width, video.height, video.fx, video.fy, video.ppx, video.ppy)
        shape = (intrinsics.height_px, intrinsics.width_px)
        index = self._received % 2
        if self._buffers[index].shape != shape:
            self._buffers[index] = np.zeros(shape, np.uint16)
        np.copyto(self._buffers[index], np.asanyarray(newest.get_data()))
        self._received += 1
        domain = newest.get_frame_timestamp_domain()
        is_unix = domain in (self._rs.timestamp_domain.global_time, self._rs.timestamp_domain.system_time)
        t_s = self._clock.capture_s(float(newest.get_timestamp()) * 1e-3, is_unix)
        return DepthFrame(t_s, number, self._buffers[index], self._depth_unit_m, intrinsics)

    def close(self) -> None:
        if not self._fault:
            self._pipeline.stop()
            self._fault = "closed"

    def _poll(self) -> Any:
        """The newest depth frame of the SDK's queue, or None."""
        newest = None
        if self._fault:
            return None
        try:
            while frames := self._pipeline.poll_for_frames():
                depth = frames.get_depth_frame()
                if depth:
                    newest = depth
        except RuntimeError as error:
            self._fault = f"RealSense: {error}"
        return newest


def _import_sdk() -> Any:
    try:
        import pyrealsense2
    except ImportError as error:
        raise PerceptionInputError(
            f"pyrealsense2 cannot be imported ({error}); install the extra 'realsense' and the system library libusb-1.0-0"
        ) from None
    return pyrealsense2
