"""What goes in (a depth frame and the pose it was taken from) and what comes out (discs and unseen sectors)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from perception.sighting import View


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Pinhole camera without distortion, in pixels."""

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float


@dataclass(frozen=True, slots=True)
class VehiclePose:
    """Pose of the vehicle at the frame's capture time: position NED in the mission frame; roll, pitch, yaw of body FRD."""

    position_ned_m: tuple[float, float, float]
    velocity_ned_m_s: tuple[float, float, float]
    roll_rad: float
    pitch_rad: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class DepthFrame:
    """One depth image: z along the optical axis in units of `depth_unit_m`, 0 = no return; `t_s` is the capture time.

    pose: of the vehicle at that time, where the source knows it (recordings, synthetic frames).
    """

    t_s: float
    number: int
    depth: NDArray[np.uint16]  # (height, width), C order
    depth_unit_m: float
    intrinsics: Intrinsics
    pose: VehiclePose | None = None


@dataclass(frozen=True, slots=True)
class PerceivedObstacles:
    """Discs and unseen sectors in the mission frame; columns as flightapp's ObstacleSet.

    discs: (n, 7) north_m, east_m, radius_m, v_north_m_s, v_east_m_s, down_top_m, down_bottom_m.
    age_s: (n,) since each disc was last seen. confidence: (n,) in [0, 1]: how sure it is that something is there.
    unseen: (k, 2) bearings [from, to) in rad clockwise from north as seen from the vehicle.
    events: what was wrong with the frame, one clear sentence each; empty for a good one.
    left_out: (k, 2) north_m, east_m of the middle of the surface that was seen in each exclusion; nan where nothing was, or
    not one whole thing alone, or where something stood before it was left out.
    view: where this frame looked and how far; None where it showed nothing.
    """

    t_s: float
    discs: NDArray[np.float64]
    age_s: NDArray[np.float64]
    confidence: NDArray[np.float64]
    unseen: NDArray[np.float64]
    events: tuple[str, ...] = ()
    left_out: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    view: View | None = None
