"""The depth camera of a pursuer in the fast simulation, as it stands in a scenario under [sensing.camera]."""

from __future__ import annotations

import math

from pydantic import Field, model_validator

from flightapp.config.loading import Strict


class DepthCamera(Strict):
    """A camera of the RealSense D435 kind that looks along the nose; the default is what the profile of the simulation has."""

    width_px: int = Field(default=848, ge=64, le=1920)
    height_px: int = Field(default=480, ge=48, le=1080)
    focal_length_px: float = Field(default=421.6, gt=0, le=10000)
    rate_hz: float = Field(default=30.0, gt=0, le=90)
    """Each frame is taken at the sub-step nearest to its time."""
    range_min_m: float = Field(default=0.3, gt=0)
    range_max_m: float = Field(default=10.0, gt=0, le=65)
    """Depths beyond are not believed; the camera goes on to show them."""
    forward_m: float = Field(default=0.1, ge=-1, le=1)
    """Of the camera from the vehicle's centre."""
    pitch_deg: float = Field(default=0.0, ge=-45, le=45)
    """Of the mounting; positive: up."""
    tilt_max_deg: float = Field(default=30.0, ge=0, le=60)
    """The vehicle tilts as its acceleration needs it, up to this; a unicycle turns harder than any tilt allows."""
    obstacle_height_m: float = Field(default=9.0, gt=6, le=100)
    """Every disc of the layout stands so high; the vehicles fly at 5 m."""

    @property
    def field_of_view_rad(self) -> float:
        """Horizontal."""
        return 2.0 * math.atan(0.5 * self.width_px / self.focal_length_px)

    @model_validator(mode="after")
    def _is_consistent(self) -> DepthCamera:
        if self.range_max_m <= self.range_min_m:
            raise ValueError(f"range_max_m = {self.range_max_m}: must be greater than range_min_m = {self.range_min_m}")
        return self
