"""The heights at which something is in the vehicle's way, and below which everything is ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

from perception.geometry import CameraPose
from perception.parameters import PerceptionParameters
from perception.types import VehiclePose

_OWN_HEIGHT_M = 0.3
"""However badly the height of the ground is known: what is less than this below the vehicle is in its way, not ground."""
_NO_GROUND_M = 1e6


@dataclass(frozen=True, slots=True)
class HeightBand:
    """Limits in metres below the camera: at a depth of z something is in the way from top_m - slope * z to bottom_m + slope * z.

    slope: how much the error of the attitude widens the band per metre. ground_m - ground_slope * z: what is lower is ground.
    """

    top_m: float
    bottom_m: float
    slope: float
    ground_m: float
    ground_slope: float


def height_band(
    pose: VehiclePose, camera: CameraPose, ground_down_m: float | None, parameters: PerceptionParameters
) -> HeightBand:
    """The band around the vehicle's altitude, widened on the side to which it climbs or sinks.

    ground_down_m: height of the ground in the mission frame, None if it is not known.
    """
    vehicle_down_m = pose.position_ned_m[2]
    move_m = pose.velocity_ned_m_s[2] * parameters.climb_look_ahead_s
    top = vehicle_down_m - parameters.band_m + min(move_m, 0.0)
    bottom = vehicle_down_m + parameters.band_m + max(move_m, 0.0)
    ground = _NO_GROUND_M
    if ground_down_m is not None:
        known = ground_down_m - parameters.ground_margin_m
        ground = min(known, max(known - parameters.ground_height_error_m, vehicle_down_m + _OWN_HEIGHT_M))
    camera_down_m = float(camera.position_ned_m[2])
    return HeightBand(
        top - camera_down_m,
        bottom - camera_down_m,
        math.tan(math.radians(parameters.attitude_error_deg)),
        ground - camera_down_m,
        parameters.ground_margin_slope,
    )
