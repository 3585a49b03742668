"""One frame together with what perception made of it: what every output of the view shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.sources.api import SourceHealth
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose


@dataclass(frozen=True, slots=True)
class Timing:
    """rate_hz: frames a second by their capture times, nan before the second frame. process_s: computing time of this frame.
    latency_s: from capture to discs, None where the frames are not live. *_p50_s, *_p99_s: over the newest frames.
    """

    rate_hz: float
    process_s: float
    process_p50_s: float
    process_p99_s: float
    latency_s: float | None = None
    latency_p50_s: float | None = None
    latency_p99_s: float | None = None


@dataclass(frozen=True, slots=True)
class Shot:
    """name: of the image file, or `frame 12`. pose: of the vehicle. exclude: (k, 3) north_m, east_m, radius_m."""

    name: str
    frame: DepthFrame
    pose: VehiclePose
    camera: CameraPose
    exclude: NDArray[np.float64]
    obstacles: PerceivedObstacles
    health: SourceHealth
    timing: Timing


def gap_m(disc: NDArray[np.float64], camera: CameraPose) -> float:
    """Distance from the camera to the front of a disc; negative inside it."""
    return float(math.hypot(disc[0] - camera.position_ned_m[0], disc[1] - camera.position_ned_m[1]) - disc[2])


def bearing_rad(disc: NDArray[np.float64], camera: CameraPose) -> float:
    """Bearing of a disc's centre from the camera, clockwise from north, in [-pi, pi]."""
    return math.atan2(disc[1] - camera.position_ned_m[1], disc[0] - camera.position_ned_m[0])


def off_axis_rad(disc: NDArray[np.float64], camera: CameraPose) -> float:
    """Bearing of a disc's centre to the right of the camera's heading, in [-pi, pi]."""
    return math.remainder(bearing_rad(disc, camera) - camera.heading_rad, 2 * math.pi)
