"""One depth frame as recorded messages: a lossless 16-bit PNG, its calibration, and what it takes to perceive it again."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import foxglove.messages as fx
import numpy as np
from numpy.typing import NDArray

from flightapp.recording.messages import CameraMounting, DepthInfo
from flightapp.vehicle.autopilot import Motion
from perception.types import DepthFrame, Intrinsics

IMAGE, CALIBRATION, INFO = "/depth", "/depth/calibration", "/depth/info"
VERSION = 1
FRAME_ID = "depth_camera"
_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE)
"""Of zlib's levels and strategies the smallest files on recorded D435 frames that do not take several times as long."""


@dataclass(frozen=True, slots=True)
class DepthCamera:
    """How the camera sits on the vehicle and how far it is believed; the ground it flies over."""

    mounting: CameraMounting
    range_min_m: float
    range_max_m: float
    ground_down_m: float


def thinned(frame: DepthFrame, stride: int) -> DepthFrame:
    """A copy with every `stride`-th row and column, and the intrinsics that belong to it.

    Pixel i of the copy is pixel i * stride of the frame, so that focal lengths and principal point divide by the stride.
    """
    depth = frame.depth[::stride, ::stride].copy()
    k = frame.intrinsics
    height_px, width_px = depth.shape
    intrinsics = Intrinsics(width_px, height_px, k.fx_px / stride, k.fy_px / stride, k.cx_px / stride, k.cy_px / stride)
    return DepthFrame(frame.t_s, frame.number, depth, frame.depth_unit_m, intrinsics, frame.pose)


def png(depth: NDArray[np.uint16]) -> bytes:
    """The image without loss; works without Python's interpreter lock."""
    good, data = cv2.imencode(".png", depth, _PNG)
    if not good:
        raise ValueError(f"a depth image of shape {depth.shape} cannot be compressed")
    return bytes(data)


def image_message(frame: DepthFrame, data: bytes) -> fx.CompressedImage:
    """`data` is the compressed image of `frame`."""
    return fx.CompressedImage(timestamp=_stamp(frame.t_s), frame_id=FRAME_ID, data=data, format="png")


def calibration_message(frame: DepthFrame) -> fx.CameraCalibration:
    """A pinhole camera without distortion, rectified."""
    k = frame.intrinsics
    return fx.CameraCalibration(
        timestamp=_stamp(frame.t_s),
        frame_id=FRAME_ID,
        width=k.width_px,
        height=k.height_px,
        K=[k.fx_px, 0.0, k.cx_px, 0.0, k.fy_px, k.cy_px, 0.0, 0.0, 1.0],
        R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P=[k.fx_px, 0.0, k.cx_px, 0.0, 0.0, k.fy_px, k.cy_px, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def info_message(frame: DepthFrame, stride: int, motion: Motion | None, camera: DepthCamera, dropped: int) -> DepthInfo:
    """motion: of the vehicle at the frame's capture time, where it is known."""
    k = frame.intrinsics
    return DepthInfo(
        version=VERSION,
        t_s=frame.t_s,
        frame_number=frame.number,
        depth_unit_m=frame.depth_unit_m,
        stride=stride,
        width_px=k.width_px,
        height_px=k.height_px,
        fx_px=k.fx_px,
        fy_px=k.fy_px,
        cx_px=k.cx_px,
        cy_px=k.cy_px,
        position_ned_m=None if motion is None else motion.state.position_ned_m.tolist(),
        velocity_ned_m_s=None if motion is None else motion.state.velocity_ned_m_s.tolist(),
        roll_rad=None if motion is None else motion.roll_rad,
        pitch_rad=None if motion is None else motion.pitch_rad,
        yaw_rad=None if motion is None else motion.state.yaw_rad,
        mounting=camera.mounting,
        range_min_m=camera.range_min_m,
        range_max_m=camera.range_max_m,
        ground_down_m=camera.ground_down_m,
        dropped=dropped,
    )


def _stamp(t_s: float) -> fx.Timestamp:
    time_ns = int(t_s * 1e9)
    return fx.Timestamp(sec=time_ns // 1_000_000_000, nsec=time_ns % 1_000_000_000)
