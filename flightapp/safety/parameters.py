"""Parameters of the supervisor's guards, as they stand in a profile under [safety]."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class SafetyParameters(BaseModel):
    """Margins and time limits of the guards."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    separation_min_m: float = Field(default=1.5, gt=0, le=100)
    """Smallest distance between the centres of two vehicles of the fleet."""
    separation_buffer_m: float = Field(default=0.2, ge=0, le=5)
    """Room kept on top of `separation_min_m` for drift and estimation error."""
    separation_passing_m: float = Field(default=0.5, ge=0, le=5)
    """A teammate whose predicted closest approach is farther than both together by this much is not braked for."""
    separation_height_m: float = Field(default=3.0, gt=0)
    """Vehicles that are at least this far apart vertically need no planar separation."""
    team_widening_max_m: float = Field(default=5.0, ge=0)
    """The separation from a teammate grows by its age times its speed, at most by this much."""
    evader_yields: bool = False
    """True: an evader keeps the separation from the pursuers too. False: its policy alone decides."""
    target_keep_out_m: float = Field(default=1.2, ge=0)
    """Smallest distance between the own centre and the evader's; 0 allows contact."""
    fence_margin_m: float = Field(default=0.5, ge=0, le=20)
    """Braking ends this far inside the fence, so that drift does not cross it."""
    push_back_m_s: float = Field(default=1.0, gt=0, le=5)
    """Speed at which a vehicle that is beyond the fence or the height band is brought back, at most."""
    height_margin_m: float = Field(default=0.2, ge=0, le=5)
    """The same for the height band."""
    obstacle_clearance_min_m: float = Field(default=0.1, ge=0, le=5)
    """Clearance between body and obstacle at which braking must have ended; the planner's margin is larger."""
    obstacle_height_margin_m: float = Field(default=0.5, ge=0.2, le=5)
    """Kept between the body and the top or underside of an obstacle that is passed above or below: what heights are known to."""
    moving_obstacle_margin_m: float = Field(default=0.2, ge=0, le=5)
    """Kept from an obstacle that moves on top of the clearance: at 2 m/s2 somebody gets 0.25 m far in half a second."""
    braking_fraction: float = Field(default=0.8, gt=0, le=1)
    """Share of the vehicle's acceleration that the guards count on when they compute a braking distance."""
    response_lag_s: float = Field(default=0.35, gt=0, le=2)
    """From a setpoint to the vehicle's answer: velocity control, link and control period together."""
    vertical_acceleration_m_s2: float = Field(default=2.0, gt=0, le=10)
    unseen_speed_m_s: float = Field(default=1.5, ge=0, le=5)
    """Top speed into a sector in which nothing was observed, and with an obstacle picture that is too old."""
    own_state_age_max_s: float = Field(default=0.3, gt=0, le=1)
    team_state_age_max_s: float = Field(default=1.0, gt=0, le=5)
    obstacles_age_max_s: float = Field(default=0.5, gt=0, le=2)
    """Older obstacles slow the vehicle down; after three times this age it stops."""
    target_age_max_s: float = Field(default=1.0, gt=0, le=10)
    """An evader not measured for longer is no longer believed to be fleeing."""
    team_link_age_max_s: float = Field(default=3.0, gt=0, le=60)
    """When no other vehicle of the fleet was heard for longer, the vehicle slows down."""
    team_link_speed_m_s: float = Field(default=2.5, gt=0, le=30)
    """Top speed while no other vehicle is heard."""
    endurance_s: float = Field(default=900.0, ge=60, le=36000)
    """How long a full battery lasts in a pursuit; a faster drain that is measured in flight counts instead."""
    return_speed_m_s: float = Field(default=4.0, gt=0, le=30)
    """Ground speed that can be counted on during the return, against the wind."""
    landing_speed_m_s: float = Field(default=0.7, gt=0, le=5)
    """Sink rate of return and landing."""
    battery_reserve_fraction: float = Field(default=0.2, ge=0, le=0.9)
    """What must be left after the way home."""
    battery_critical_fraction: float = Field(default=0.1, ge=0, le=0.5)
    """With less the vehicle lands where it is."""
