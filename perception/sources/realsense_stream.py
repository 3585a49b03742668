"""The depth stream of one RealSense device: choose the mode, start, stop, read what a frame says of itself.

It works on the SDK's sensors, not on `rs.pipeline`: the pipeline does not see a software device, and what runs in the field
would not run in the tests. Frames go to a callback, not to an `rs.frame_queue`: in Python the SDK takes the queue for a
callback too, and a full one then waits for room while it holds the interpreter's lock (SDK 2.59.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from perception.errors import PerceptionInputError
from perception.sources.realsense_device import label, one_line, usb_warning
from perception.types import Intrinsics


@dataclass(frozen=True, slots=True)
class DepthMode:
    """What is asked of a camera."""

    width_px: int = 848
    height_px: int = 480
    rate_hz: float = 30.0


class DepthStream:
    """PerceptionInputError if the device has no depth sensor or does not offer the mode (None: the first it has).

    name: what sentences call the device instead of its own name. emitter: infrared projector on or off; None leaves it as it is.
    """

    def __init__(self, rs: Any, device: Any, mode: DepthMode | None, *, name: str = "", emitter: bool | None = None) -> None:
        self._rs = rs
        self.label = name or label(rs, device)
        self.warning = usb_warning(rs, device)
        self._sensor = self._depth_sensor(device)
        try:
            self._profile = self._choose(mode)
            if emitter is not None and self._sensor.supports(rs.option.emitter_enabled):
                self._sensor.set_option(rs.option.emitter_enabled, float(emitter))
            # The SDK stores 0.001 in single precision: 0.0010000000475.
            self.depth_unit_m = round(float(self._sensor.get_depth_scale()), 9)
        except RuntimeError as error:
            raise PerceptionInputError(
                f"{self.label}: does not answer ({one_line(error)}); unplug it and plug it in again"
            ) from None

    def start(self, on_frame: Callable[[Any], None]) -> None:
        """Frames go to `on_frame`, in a thread of the SDK. PerceptionInputError if the device refuses."""
        try:
            self._sensor.open(self._profile)
            self._sensor.start(on_frame)
        except RuntimeError as error:
            self.stop()
            raise PerceptionInputError(
                f"{self.label}: cannot be started ({one_line(error)}); check that no other program uses it"
            ) from None

    def stop(self) -> None:
        """Whatever state the device is in: one that is gone cannot be told to stop."""
        for step in (self._sensor.stop, self._sensor.close):
            try:
                step()
            except RuntimeError:
                continue

    def temperature_c(self) -> float | None:
        """Of the processor, or else of the projector; None where neither is told. Asks the device: not for every frame."""
        for option in (self._rs.option.asic_temperature, self._rs.option.projector_temperature):
            try:
                if self._sensor.supports(option):
                    return float(self._sensor.get_option(option))
            except RuntimeError:
                continue
        return None

    def stamp(self, frame: Any) -> tuple[float, bool]:
        """The frame's time stamp in s, and whether it is in the host's Unix time."""
        domains = self._rs.timestamp_domain
        is_unix = frame.get_frame_timestamp_domain() in (domains.global_time, domains.system_time)
        return float(frame.get_timestamp()) * 1e-3, is_unix

    def _depth_sensor(self, device: Any) -> Any:
        try:
            return device.first_depth_sensor()
        except RuntimeError:
            raise PerceptionInputError(
                f"{self.label}: has no depth sensor; a D400 camera or a recording of one is wanted"
            ) from None

    def _choose(self, mode: DepthMode | None) -> Any:
        offered = [
            profile.as_video_stream_profile()
            for profile in self._sensor.get_stream_profiles()
            if profile.stream_type() == self._rs.stream.depth and profile.format() == self._rs.format.z16
        ]
        if not offered:
            raise PerceptionInputError(f"{self.label}: offers no 16-bit depth (z16)")
        if mode is None:
            return offered[0]
        for profile in offered:
            if (profile.width(), profile.height(), profile.fps()) == (mode.width_px, mode.height_px, mode.rate_hz):
                return profile
        hint = f"; {self.warning}" if self.warning else ""
        wanted = f"{mode.width_px}x{mode.height_px} at {mode.rate_hz:g} Hz"
        raise PerceptionInputError(f"{self.label}: {wanted} is not offered; it has {_modes(offered)}{hint}")


def intrinsics_of(frame: Any) -> Intrinsics:
    """Of the frame's own profile: the device may have scaled the image."""
    lens = frame.get_profile().as_video_stream_profile().get_intrinsics()
    return Intrinsics(lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy)


def _modes(profiles: list[Any]) -> str:
    rates: dict[tuple[int, int], set[int]] = {}
    for profile in profiles:
        rates.setdefault((profile.width(), profile.height()), set()).add(profile.fps())
    return ", ".join(
        f"{width}x{height} at {'/'.join(str(rate) for rate in sorted(rates[width, height]))} Hz"
        for width, height in sorted(rates, reverse=True)
    )
