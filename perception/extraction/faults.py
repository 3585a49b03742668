"""What makes a frame unusable before anything is measured in it: size, pixels, lens data, unit, pose, a frozen picture."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from perception.geometry import is_finite
from perception.parameters import PerceptionParameters
from perception.types import DepthFrame, Intrinsics, VehiclePose

_CHECK_STEP_PX = 16
_SIDE_MIN_PX = 16
_SIDE_MAX_PX = 8192
_UNIT_MIN_M = 1e-5
_UNIT_MAX_M = 0.1
_FOCAL_MIN_OF_WIDTH = 0.15
_FOCAL_MAX_OF_WIDTH = 20.0
_POSITION_MAX_M = 1e5
_SPEED_MAX_M_S = 200.0
_ANGLE_MAX_RAD = 100.0


class FaultFinder:
    """Checks one frame after the other; remembers the last picture to notice a frozen one."""

    def __init__(self, parameters: PerceptionParameters) -> None:
        self._frozen_frames_max = parameters.frozen_frames_max
        self.reset()

    def reset(self) -> None:
        """Forget the last picture."""
        self._last_sample: NDArray[np.uint16] | None = None
        self._same = 0

    def fault(self, frame: DepthFrame, pose: VehiclePose) -> str:
        """One sentence, or nothing."""
        return lens_fault(frame.intrinsics) or _picture_fault(frame) or _pose_fault(pose) or self._frozen(frame.depth)

    def _frozen(self, depth: NDArray[np.uint16]) -> str:
        sample = depth[::_CHECK_STEP_PX, ::_CHECK_STEP_PX]
        same = self._last_sample is not None and np.array_equal(sample, self._last_sample) and bool(sample.any())
        self._same = self._same + 1 if same else 0
        self._last_sample = sample.copy()
        if self._frozen_frames_max and self._same >= self._frozen_frames_max:
            return f"depth image is frozen: the same pixels for {self._same + 1} frames"
        return ""


def lens_fault(k: Intrinsics) -> str:
    """What is wrong with intrinsics, in one sentence, or nothing."""
    for name in ("width_px", "height_px"):
        side = getattr(k, name)
        if not isinstance(side, int | np.integer):
            return f"camera intrinsics: {name} = {side!r} must be a whole number of pixels"
        if not _SIDE_MIN_PX <= side <= _SIDE_MAX_PX:
            return f"camera intrinsics: {name} = {side} must be from {_SIDE_MIN_PX} to {_SIDE_MAX_PX}"
    for name in ("fx_px", "fy_px", "cx_px", "cy_px"):
        if not isinstance(getattr(k, name), Real):
            return f"camera intrinsics: {name} = {getattr(k, name)!r} must be a number"
    low, high = _FOCAL_MIN_OF_WIDTH * k.width_px, _FOCAL_MAX_OF_WIDTH * k.width_px
    for name in ("fx_px", "fy_px"):
        focal = getattr(k, name)
        if not low <= focal <= high:
            return f"camera intrinsics: {name} = {focal:g} must be from {low:g} to {high:g} at a width of {k.width_px}"
    for name, side in (("cx_px", k.width_px), ("cy_px", k.height_px)):
        centre = getattr(k, name)
        if not 0 < centre < side:
            return f"camera intrinsics: {name} = {centre:g} lies outside the {k.width_px}x{k.height_px} image"
    return ""


def _picture_fault(frame: DepthFrame) -> str:
    depth, k = frame.depth, frame.intrinsics
    if not isinstance(depth, np.ndarray):
        return f"depth frame is no array of pixels but {type(depth).__name__}"
    if depth.shape != (k.height_px, k.width_px):
        size = "x".join(str(length) for length in depth.shape[::-1])
        return f"depth frame has the wrong size: {size or 'none'} instead of {k.width_px}x{k.height_px}"
    if depth.dtype != np.uint16:
        return f"depth frame has no 16-bit pixels: {depth.dtype} instead of uint16"
    if not isinstance(frame.depth_unit_m, Real):
        return f"depth_unit_m = {frame.depth_unit_m!r} must be a number"
    if not _UNIT_MIN_M <= frame.depth_unit_m <= _UNIT_MAX_M:
        return f"depth_unit_m = {frame.depth_unit_m:g} must be from {_UNIT_MIN_M:g} to {_UNIT_MAX_M:g}"
    if not math.isfinite(frame.t_s):
        return f"the depth frame's time is {frame.t_s}, not a number of seconds"
    return ""


def _pose_fault(pose: VehiclePose) -> str:
    if not is_finite(pose):
        return "vehicle pose at the depth frame's time is not finite"
    for name, values, limit in (
        ("position_ned_m", pose.position_ned_m, _POSITION_MAX_M),
        ("velocity_ned_m_s", pose.velocity_ned_m_s, _SPEED_MAX_M_S),
        ("roll, pitch, yaw in rad", (pose.roll_rad, pose.pitch_rad, pose.yaw_rad), _ANGLE_MAX_RAD),
    ):
        for value in values:
            if abs(value) > limit:
                return f"vehicle pose at the depth frame's time: {name} holds {value:g}, must be within +-{limit:g}"
    return ""
