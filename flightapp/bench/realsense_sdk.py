"""The RealSense SDK's own first steps on the same frames: its decimation filter and its point cloud."""

from __future__ import annotations

from typing import Any

import numpy as np

from flightapp.bench.depth_flight import FRAMES, DepthFlight
from flightapp.bench.measurement import Measurement, Work, measure
from perception.types import DepthFrame, Intrinsics

SDK_ROW = "RealSense SDK, decimation and point cloud"
DECIMATION = 2
_DELIVERY_MAX_MS = 2000


def sdk_measurement(flight: DepthFlight, seconds: float) -> Measurement | None:
    """Decimated by 2 and back-projected; no band, no discs. None where pyrealsense2 cannot be imported."""
    try:
        import pyrealsense2 as rs
    except ImportError:
        return None
    frames = _as_sdk_frames(rs, flight)
    decimation, cloud = rs.decimation_filter(), rs.pointcloud()
    decimation.set_option(rs.option.filter_magnitude, DECIMATION)

    def project(frame: Any) -> None:
        if cloud.calculate(decimation.process(frame)).size() == 0:
            raise RuntimeError("the SDK's point cloud is empty, this would measure something else")

    return measure(Work(SDK_ROW, lambda k: frames[k % FRAMES], project), seconds)


def _as_sdk_frames(rs: Any, flight: DepthFlight) -> list[Any]:
    """The flight as frames of a software device, as the SDK would hand them out."""
    first = flight.shots[0][0]
    device = rs.software_device()
    sensor = device.add_sensor("depth")
    profile = sensor.add_video_stream(_stream(rs, first.intrinsics))
    sensor.add_read_only_option(rs.option.depth_units, first.depth_unit_m)
    queue = rs.frame_queue(1, keep_frames=True)
    sensor.open(profile)
    sensor.start(queue)
    frames = []
    for frame, _ in flight.shots:
        sensor.on_video_frame(_video_frame(rs, profile, frame))
        frames.append(queue.wait_for_frame(_DELIVERY_MAX_MS))
    sensor.stop()
    sensor.close()
    return frames


def _stream(rs: Any, lens: Intrinsics) -> Any:
    intrinsics = rs.intrinsics()
    intrinsics.width, intrinsics.height = lens.width_px, lens.height_px
    intrinsics.fx, intrinsics.fy, intrinsics.ppx, intrinsics.ppy = lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px
    intrinsics.model, intrinsics.coeffs = rs.distortion.none, [0.0] * 5
    stream = rs.video_stream()
    stream.type, stream.fmt, stream.bpp, stream.fps = rs.stream.depth, rs.format.z16, 2, 30
    stream.index, stream.uid = 0, 0
    stream.width, stream.height, stream.intrinsics = lens.width_px, lens.height_px, intrinsics
    return stream


def _video_frame(rs: Any, profile: Any, frame: DepthFrame) -> Any:
    video = rs.software_video_frame()
    video.pixels = np.ascontiguousarray(frame.depth)
    video.stride, video.bpp = 2 * frame.intrinsics.width_px, 2
    video.timestamp, video.frame_number = frame.t_s * 1e3, frame.number
    video.domain, video.profile = rs.timestamp_domain.hardware_clock, profile.as_video_stream_profile()
    return video
