"""The scenario's table `[volume]`: where it is given, vehicles fly up and down and obstacles have heights."""

from __future__ import annotations

from pydantic import Field, model_validator

from flightapp.config.loading import Strict


class Volume(Strict):
    """Heights are metres above the ground, which is where the datum is."""

    disc_height_m: tuple[float, float] = (3.0, 12.0)
    """Least and greatest height of obstacles, which stand on the ground; drawn anew for each disc and seed."""
    pursuer_height_m: float = Field(default=5.0, gt=0)
    """Of all pursuers at the start."""
    evader_height_m: float = Field(default=5.0, gt=0)
    climb_acceleration_m_s2: float = Field(default=3.0, gt=0)
    """Of all vehicles, climbing and sinking."""
    climb_response_s: float = Field(default=0.2, gt=0)
    """Time constant from the commanded vertical velocity to the flown one."""

    @model_validator(mode="after")
    def _is_range(self) -> Volume:
        low, high = self.disc_height_m
        if not 0.0 < low <= high:
            raise ValueError(f"disc_height_m = [{low}, {high}]: must be least and greatest height, both above 0")
        return self
