"""Parameters of the encirclement strategies. Units stand in the names; `build` refuses what cannot be."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator, model_validator

from flightapp.planning.capture import CaptureRule
from flightapp.planning.geometry.polygons import polygons
from flightapp.planning.parameters import StrategyParameters

Vehicle = Literal["single-integrator", "multirotor", "unicycle", "triple-integrator"]
Corners = tuple[tuple[float, float], ...]


class EncirclementParameters(StrategyParameters):
    """Of `oa-ecbvc`; the methods beside it leave what they have no use for."""

    # facts of mission and vehicle
    capture: CaptureRule = CaptureRule()
    """The mission's capture section."""
    control_period_s: float = Field(default=0.1, gt=0, le=1)
    """Time between two decisions, where the observation does not say it."""
    evader_speed_assumed_m_s: float = Field(default=4.0, ge=0)
    """Top speed of the evader: how far it may be from where it was seen last."""
    evader_radius_m: float = Field(default=0.0, ge=0)
    """The evader's body: with a capture radius not larger than both bodies, capture is contact: a flag says so."""
    polygons_m: tuple[Corners, ...] = ()
    """Convex obstacles of the map, corners as (north, east)."""
    flight_area_m: tuple[float, float, float, float] | None = None
    """The area that a pursuer's centre does not leave: least north, least east, greatest north, greatest east."""
    vehicle: Vehicle = "multirotor"
    """`single-integrator`: flies any velocity at once, as the paper's proof wants it; `multirotor`: takes a velocity, needs room
    to brake; `unicycle`: only along its nose; `triple-integrator`: minimum-jerk primitives."""

    # room
    team_separation_m: float | None = Field(default=None, gt=0)
    """Smallest distance of two pursuers' centres; without it, two body radii and two safety margins."""
    braking_share: float = Field(default=0.8, gt=0, le=1)
    """Share of the acceleration limit that braking may assume."""
    reaction_s: float = Field(default=0.55, ge=0)
    """Time from a decision until the vehicle brakes: its lag plus the age of what it sees. Not of a single integrator."""
    response_lag_s: float = Field(default=0.45, ge=0)
    """Lag of the velocity loop: everything is judged where this lag puts it. Only of a multirotor."""
    leaving_gain_per_s: float = Field(default=2.0, gt=0)
    """Speed out of where the vehicle must not be, per metre of depth. A single integrator leaves at full speed."""
    leaving_speed_max_m_s: float = Field(default=1.0, gt=0)
    """Highest speed of that."""
    obstacle_range_m: float = Field(default=30.0, gt=0)
    """Discs beyond are ignored."""
    vehicle_disc_m: float = Field(default=0.25, ge=0)
    """A disc whose surface is this near to the centre of a teammate or of the evader is that vehicle."""
    vehicle_radius_max_m: float = Field(default=0.6, ge=0)
    """Larger discs are never taken for a vehicle."""

    # the box around the evader and its shrinking (section III-C of the paper)
    box: Literal["square", "rect"] = "square"
    """`rect` is the paper's: it has no area where all pursuers are level with the evader."""
    shrink: Literal["latch", "reopen", "eq8"] = "latch"
    """Once encircled: `latch` shrinks to the end; `reopen` returns to the pursuers' extent where the evader has left their hull
    for `reopen_after_s`; `eq8` never shrinks by itself."""
    shrink_share: float = Field(default=1.0, gt=0, le=1)
    """The box shrinks by this share of what a pursuer flies; at 1, the paper's, faster than they follow an evader that flees."""
    reopen_after_s: float = Field(default=1.0, ge=0)
    box_half_min_m: float | None = Field(default=None, gt=0)
    """Smallest half size of the box; without it, from the capture rule and the number of pursuers."""

    # the step
    approach_gain_1_s: float | None = Field(default=None, gt=0)
    """Speed per metre to the goal; without it, the goal is reached in one period by a single integrator, in 0.8 s by others."""
    evader_feed_forward: float | None = Field(default=None, ge=0, le=1)
    """Share of the evader's velocity that is flown beside the approach: with it the box is kept up with, not trailed. Without it,
    0 for a single integrator, 1 for others."""

    # what is old
    prediction_max_s: float = Field(default=1.0, ge=0)
    """States are moved on by their velocity over no more than this."""
    position_sigma_m: float = Field(default=0.0, ge=0)
    """Standard deviation of one's own and others' positions; three of them are kept free."""
    mate_stale_s: float = Field(default=1.0, gt=0)
    """An older teammate is an obstacle that grows with its age."""
    mate_silent_s: float = Field(default=3.0, gt=0)
    """An older one no longer counts for the encirclement, and the obstacle no longer grows."""
    target_stale_s: float = Field(default=1.0, gt=0)
    """The box does not shrink while the target's track is older."""
    target_search_s: float = Field(default=5.0, gt=0)
    """From this age its last place is searched."""
    target_lost_s: float = Field(default=10.0, gt=0)
    """From this age the vehicle holds."""

    # getting out of a standstill (not in the paper)
    deadlock: bool = True
    """Where no progress is made far from the evader: a way around by a search on a grid, then to the right along what blocks."""
    deadlock_window_s: float = Field(default=2.0, gt=0)
    deadlock_progress: float = Field(default=0.2, gt=0, le=1)
    """Less than this share of the top speed over the window is no progress."""
    guided_s: float = Field(default=3.0, gt=0)
    """How long a way around is followed before the cell's centroid counts again."""
    guidance_cell_m: float = Field(default=0.25, gt=0.1, le=2)
    """Side of a cell of the search, which covers 128 x 128 of them around the vehicle."""

    # of the methods beside it
    information_sigma_m: float = Field(default=3.0, gt=0)
    """`oavc`: width of the information density around the evader."""
    surround_gain_1_s: float = Field(default=1.0, gt=0)
    """`surround-hunt`: angular speed per angle off the middle between the neighbours."""
    surround_hunting_share: float = Field(default=0.7, ge=0, le=1)
    """`surround-hunt`: tangential speed is multiplied by this once the widest gap is below 0.9 pi."""
    spaced_radius_share: float = Field(default=0.8, gt=0, le=1)
    """`spaced`: the ring shrinks to this share of the capture radius."""

    # triple integrator (section III-D)
    jerk_weight: float = Field(default=0.02, gt=0)
    """Weight of the mean squared jerk."""
    goal_weight: float = Field(default=1.0, gt=0)
    """Weight of the mean squared distance to the goal."""
    primitive_lead_s: float = Field(default=3.0, ge=0)
    """A motion leads to where the evader's velocity takes the goal in this time."""
    primitive_lag_s: float = Field(default=0.0, ge=0)
    """Lag of a velocity loop that takes no acceleration: the commanded velocity is ahead by what that makes of it."""

    @field_validator("polygons_m")
    @classmethod
    def _are_polygons(cls, given: tuple[Corners, ...]) -> tuple[Corners, ...]:
        polygons(given)
        return given

    @field_validator("flight_area_m")
    @classmethod
    def _has_extent(cls, area: tuple[float, float, float, float] | None) -> tuple[float, float, float, float] | None:
        if area is not None and (area[0] >= area[2] or area[1] >= area[3]):
            raise ValueError("must be least north, least east, greatest north, greatest east")
        return area

    @model_validator(mode="after")
    def _is_consistent(self) -> EncirclementParameters:
        if self.mate_silent_s < self.mate_stale_s:
            raise ValueError(f"mate_silent_s = {self.mate_silent_s} must be at least mate_stale_s = {self.mate_stale_s}")
        if not self.target_stale_s <= self.target_search_s <= self.target_lost_s:
            raise ValueError("target_stale_s, target_search_s and target_lost_s must follow one another in this order")
        return self
