"""What the source `synthetic` shows: ten seconds through poles, trees and a wall, for a look without camera or recording."""

from __future__ import annotations

import math

import numpy as np

from perception.synthetic.scene import Scene
from perception.types import Intrinsics, VehiclePose

DURATION_S = 10.0
_HEIGHT_M = 2.0
_SPEED_M_S = 1.5
_SWING_RAD = math.radians(25.0)
_SWING_PERIOD_S = 5.0
_HORIZONTAL_VIEW_RAD = math.radians(90.4)


def demonstration_scene() -> Scene:
    """A 3 cm pole, two lamp posts, three trees and a wall across the way, on flat ground."""
    cylinders = np.array(
        [
            [6.0, -0.8, 0.015, 4.0],
            [9.0, 1.5, 0.06, 5.0],
            [15.0, -1.5, 0.06, 5.0],
            [8.0, -3.5, 0.25, 8.0],
            [13.0, 3.0, 0.2, 8.0],
            [18.0, 0.5, 0.35, 9.0],
        ]
    )
    boxes = np.array([[24.0, 0.0, 0.3, 12.0, 4.0, 0.0]])
    return Scene(cylinders, boxes)


def demonstration_motion(t_s: float) -> VehiclePose:
    """North at walking pace, two metres up, looking left and right on the way."""
    phase = 2 * math.pi * t_s / _SWING_PERIOD_S
    return VehiclePose(
        position_ned_m=(_SPEED_M_S * t_s, 0.0, -_HEIGHT_M),
        velocity_ned_m_s=(_SPEED_M_S, 0.0, 0.0),
        roll_rad=math.radians(3.0) * math.sin(phase),
        pitch_rad=math.radians(-4.0),
        yaw_rad=_SWING_RAD * math.sin(phase),
    )


def demonstration_intrinsics(width_px: int, height_px: int) -> Intrinsics:
    """Of a D435's depth image (90.4 degrees wide) at the given size."""
    focal_px = width_px / 2 / math.tan(_HORIZONTAL_VIEW_RAD / 2)
    return Intrinsics(width_px, height_px, focal_px, focal_px, width_px / 2, height_px / 2)
