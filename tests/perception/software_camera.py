"""A RealSense camera without hardware: the SDK's software device, fed by the test."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from perception.types import Intrinsics

LENS = Intrinsics(64, 48, 32.5, 33.5, 31.5, 24.5)
SERIAL_NUMBER = "000000000042"


def sdk() -> Any:
    """pyrealsense2; skips the test where it cannot be imported."""
    return pytest.importorskip(
        "pyrealsense2", reason="pyrealsense2 or its system library libusb-1.0-0 is missing", exc_type=ImportError
    )


class SoftwareCamera:
    """Offers depth of `lens`'s size at 30 and 90 frames a second.

    serial_number, usb: as the device tells them. temperature_c: of its processor; None: it does not tell.
    """

    def __init__(
        self,
        lens: Intrinsics = LENS,
        *,
        serial_number: str = SERIAL_NUMBER,
        usb: str = "3.2",
        depth_unit_m: float = 0.001,
        temperature_c: float | None = None,
    ) -> None:
        self._rs = rs = sdk()
        self.lens = lens
        self.serial_number = serial_number
        self.depth_unit_m = depth_unit_m
        self.device = rs.software_device()
        for kind, text in (
            (rs.camera_info.name, "Software D435"),
            (rs.camera_info.serial_number, serial_number),
            (rs.camera_info.usb_type_descriptor, usb),
        ):
            self.device.register_info(kind, text)
        self.sensor = self.device.add_sensor("Stereo Module")
        self._profile = self._add_stream(1, 30).as_video_stream_profile()
        self._add_stream(2, 90)
        self.sensor.add_read_only_option(rs.option.depth_units, depth_unit_m)
        self.sensor.add_read_only_option(rs.option.stereo_baseline, 50.0)
        if temperature_c is not None:
            self.sensor.add_read_only_option(rs.option.asic_temperature, temperature_c)
        self.device.create_matcher(rs.matchers.default)
        self._keep: list[Any] = []

    def send(self, pixels: np.ndarray | int, number: int, *, stamp_s: float = 0.0, is_unix: bool = False) -> None:
        """Deliver one frame, before this returns; an int stands for an image of that value."""
        rs = self._rs
        if isinstance(pixels, int):
            pixels = np.full((self.lens.height_px, self.lens.width_px), pixels, np.uint16)
        self._keep = [*self._keep[-40:], pixels]
        frame = rs.software_video_frame()
        frame.pixels, frame.stride, frame.bpp = pixels, 2 * self.lens.width_px, 2
        frame.timestamp = 1000.0 * stamp_s
        frame.domain = rs.timestamp_domain.global_time if is_unix else rs.timestamp_domain.hardware_clock
        frame.frame_number, frame.profile, frame.depth_units = number, self._profile, self.depth_unit_m
        self.sensor.on_video_frame(frame)

    def record(self, file: Path, numbers: list[int], *, period_s: float = 1 / 30) -> None:
        """Write frames with these numbers, each filled with its number, to a .db3 file; the camera is used up then."""
        rs = self._rs
        recorder = rs.recorder(str(file), self.device)
        recorded = recorder.query_sensors()[0]
        recorded.open(recorded.get_stream_profiles()[0])
        recorded.start(rs.frame_queue(1))
        for number in numbers:
            self.send(number, number, stamp_s=100.0 + number * period_s)
        recorded.stop()
        recorded.close()

    def _add_stream(self, uid: int, rate_hz: int) -> Any:
        rs, lens = self._rs, self.lens
        intrinsics = rs.intrinsics()
        intrinsics.width, intrinsics.height = lens.width_px, lens.height_px
        intrinsics.fx, intrinsics.fy, intrinsics.ppx, intrinsics.ppy = lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px
        intrinsics.model, intrinsics.coeffs = rs.distortion.none, [0.0] * 5
        stream = rs.video_stream()
        stream.type, stream.index, stream.uid, stream.fmt = rs.stream.depth, 0, uid, rs.format.z16
        stream.width, stream.height, stream.fps, stream.bpp = lens.width_px, lens.height_px, rate_hz, 2
        stream.intrinsics = intrinsics
        return self.sensor.add_video_stream(stream, uid == 1)
