"""Frames: body (forward, right, down), optical (right, down, forward), mission (north, east, down), level (see below)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from perception.types import VehiclePose

Matrix = NDArray[np.float64]

_FRD_FROM_OPTICAL = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


class MountingLike(Protocol):
    """Pose of the camera in the body frame; zero angles look straight ahead."""

    @property
    def forward_m(self) -> float: ...
    @property
    def right_m(self) -> float: ...
    @property
    def down_m(self) -> float: ...
    @property
    def roll_deg(self) -> float: ...
    @property
    def pitch_deg(self) -> float: ...
    @property
    def yaw_deg(self) -> float: ...


@dataclass(frozen=True, slots=True)
class CameraMounting:
    """A mounting by value, for callers without a profile."""

    forward_m: float = 0.0
    right_m: float = 0.0
    down_m: float = 0.0
    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    yaw_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class CameraPose:
    """Where the camera is and looks.

    position_ned_m: (3,) in the mission frame. rotation: (3, 3), mission frame <- optical frame.
    heading_rad: bearing of the optical axis. level: (3, 3), level frame <- optical frame; the level frame sits in the camera
    with its axes forward (along the heading, horizontal), right, down.
    """

    position_ned_m: Matrix
    rotation: Matrix
    heading_rad: float
    level: Matrix


def rotation_from_angles(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Matrix:
    """(3, 3) parent <- child of the aerospace sequence yaw, pitch, roll; both frames forward, right, down."""
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    cp, sp = math.cos(pitch_rad), math.sin(pitch_rad)
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def camera_pose(pose: VehiclePose, mounting: MountingLike) -> CameraPose:
    """The camera's pose in the mission frame."""
    body = rotation_from_angles(pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
    mount = rotation_from_angles(
        math.radians(mounting.roll_deg), math.radians(mounting.pitch_deg), math.radians(mounting.yaw_deg)
    )
    rotation = body @ mount @ _FRD_FROM_OPTICAL
    position = np.array(pose.position_ned_m) + body @ np.array([mounting.forward_m, mounting.right_m, mounting.down_m])
    heading = math.atan2(rotation[1, 2], rotation[0, 2])
    level = rotation_from_angles(0.0, 0.0, -heading) @ rotation
    return CameraPose(position, rotation, heading, level)


def is_finite(pose: VehiclePose) -> bool:
    """Whether every number of the pose is one."""
    numbers = (*pose.position_ned_m, *pose.velocity_ned_m_s, pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
    return all(math.isfinite(number) for number in numbers)
