"""Parameters of the way from a depth frame to discs, as they stand in a profile under [perception]."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field, model_validator


class PerceptionParameters(BaseModel):
    """Extraction and short-term memory."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    stride_px: int = Field(default=2, ge=1, le=8)
    """Every how many rows and columns a depth pixel is used."""

    band_m: float = Field(default=1.0, gt=0, le=10)
    """Obstacles count from this much above to this much below the vehicle's own altitude."""
    climb_look_ahead_s: float = Field(default=1.0, ge=0, le=10)
    """The band reaches further, up or down, by how far the vehicle climbs or sinks in this time: 0.2 s until it reacts, 0.8 s to
    stop 2 m/s with a third of gravity."""
    attitude_error_deg: float = Field(default=2.0, ge=0, le=15)
    """The band widens with distance by this angle: error of the attitude estimate and of the mounting, and what turns between
    the times of pose and picture."""
    ground_margin_m: float = Field(default=0.3, ge=0, le=5)
    """What is less than this above the known ground is ground."""
    ground_margin_slope: float = Field(default=0.03, ge=0, le=0.5)
    """Added to the ground margin per metre of distance: 0.03 allows for 1.7 degrees of attitude error."""
    ground_height_error_m: float = Field(default=0.5, ge=0, le=5)
    """The height of the ground is known this well. That much more counts as ground, but nothing less than 0.3 m below the
    vehicle."""

    depth_noise_1_m: float = Field(default=0.004, gt=0, le=0.05)
    """Standard deviation of the depth is this times the distance squared (D435: about 0.004 m at 1 m, 0.06 m at 4 m)."""
    cell_m: float = Field(default=0.12, ge=0.02, le=1)
    """Depth of a grouping cell at short range; further away it grows with the depth noise."""
    visible_height_min_m: float = Field(default=0.2, gt=0, le=5)
    """Surfaces that show less than this in height are not kept, unless they go on to the side."""
    thin_height_min_m: float = Field(default=0.04, gt=0, le=5)
    """Level things, such as a branch, are kept if they show this much in height over several bearing bins."""
    visible_area_min_m2: float = Field(default=0.015, gt=0, le=5)
    """Connected surfaces that show less than this are speckle. Pixels needed fall with distance squared and stride squared."""
    pixels_min: int = Field(default=12, ge=1, le=10000)
    """A connected surface needs this many used pixels, however far away it is."""

    disc_radius_min_m: float = Field(default=0.15, gt=0, le=2)
    """No disc is smaller: the back of an obstacle is never seen."""
    disc_radius_max_m: float = Field(default=0.6, gt=0, le=3)
    """Radius of the discs of which a wall is made."""
    round_radius_max_m: float = Field(default=1.5, gt=0, le=10)
    """Something that looks round becomes one disc up to this radius, a row of small ones beyond."""
    surface_tolerance_m: float = Field(default=0.1, gt=0, le=1)
    """How far discs may bulge out of a flat surface towards the camera, and a round one's surface may stand out of its disc."""
    discs_max: int = Field(default=60, ge=1, le=1000)
    """At most this many discs go out, nearest first."""

    look_distance_m: float = Field(default=3.0, gt=0, le=30)
    """Distance at which a bearing must show enough of the height band to count as seen."""
    look_fraction_min: float = Field(default=0.3, gt=0, le=1)
    """Fraction of the height band at `look_distance_m` that must be in the picture for a bearing to count as seen."""
    ground_return_fraction_min: float = Field(default=0.2, gt=0, le=1)
    """Where the ground must be in range, a bearing counts as seen only if at least this fraction of its pixels returned."""
    return_fraction_min: float = Field(default=0.005, gt=0, le=1)
    """A bearing counts as seen only if at least this fraction of all its pixels returned: of 60 degrees in height, 0.3."""
    frozen_frames_max: int = Field(default=10, ge=0, le=1000)
    """This many frames in a row with the very same pixels mean a frozen camera; 0 switches the check off."""

    free_memory_s: float = Field(default=0.4, ge=0, le=0.5)
    """How long space that was seen to be free counts as free where the picture shows nothing but perhaps sky; 0 switches it off.
    No longer than obstacles may be old: the supervisor slows the vehicle down when they are older than 0.5 s."""

    memory_s: float = Field(default=3.0, ge=0, le=60)
    """How long a disc that has left the view is remembered; 0 switches memory off."""
    memory_growth_m_s: float = Field(default=0.05, ge=0, le=2)
    """Growth of the radius of a remembered disc."""
    memory_moving_s: float = Field(default=1.0, ge=0, le=60)
    """How long a moving disc that has left the view, or is hidden, is remembered and moved on; at most `memory_s`."""
    memory_growth_moving_m_s: float = Field(default=0.5, ge=0, le=5)
    """Growth of the radius of a remembered moving disc."""
    association_m: float = Field(default=0.5, gt=0, le=5)
    """A remembered disc in view this close to an observed one (beyond the larger radius) is the same and gives way."""
    bearing_error_deg: float = Field(default=1.0, ge=0, le=10)
    """Error of the bearing of a disc from heading, attitude and the time of the pose: a displacement that this could explain is
    no movement."""
    moving_speed_min_m_s: float = Field(default=0.3, gt=0, le=5)
    """What is slower counts as standing still."""
    moving_after_s: float = Field(default=0.3, ge=0.05, le=0.5)
    """Nothing counts as moving before it was followed for this long."""
    manoeuvre_m_s2: float = Field(default=1.0, gt=0, le=20)
    """Moving objects change their velocity by about this much in a second; more follows turns sooner and noise more closely."""

    @model_validator(mode="after")
    def _radii_are_ordered(self) -> PerceptionParameters:
        if self.disc_radius_max_m < self.disc_radius_min_m:
            raise ValueError(
                f"disc_radius_max_m = {self.disc_radius_max_m} must not be less than disc_radius_min_m = {self.disc_radius_min_m}"
            )
        if self.surface_tolerance_m > self.disc_radius_max_m:
            raise ValueError(
                f"surface_tolerance_m = {self.surface_tolerance_m} must not exceed disc_radius_max_m = {self.disc_radius_max_m}"
            )
        return self
