"""Every number of the hunting planner and its baselines, with its unit."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from flightapp.planning.capture import CaptureRule
from flightapp.planning.parameters import StrategyParameters


class HuntingParameters(StrategyParameters):
    """Parameters of `hunting` and its baselines. Vehicle limits are not among them: they come with `limits`."""

    # facts of the mission, as every planner is given them
    capture: CaptureRule = CaptureRule()
    """The mission's capture section."""
    evader_speed_assumed_m_s: float = Field(default=4.0, gt=0)
    """Top speed of the target: no prediction is faster."""
    control_period_s: float = Field(default=0.1, gt=0)
    """Between two decisions."""
    reaction_s: float = Field(default=0.55, ge=0)
    """Time from a decision until the vehicle brakes."""
    response_lag_s: float = Field(default=0.45, ge=0)
    """Lag of the velocity loop; motions are judged from where this lag puts the vehicle."""
    command_blend: float = Field(default=0.08, ge=0, le=1)
    """Centre of the window: this share of the measured velocity, the rest of the last command."""
    vehicle_radius_max_m: float = Field(default=0.6, ge=0)
    """Larger discs are never taken for a vehicle that was sighted as an obstacle."""

    # what the planner is made of: the baselines are choices here
    goal: Literal["meeting", "target"] = "meeting"
    """Slots around the base point where the target is met, or around its present position (tracking)."""
    slots: bool = True
    """False: everybody flies to the target itself and stops at the hunting radius."""
    window: Literal["horizon", "cycle"] = "horizon"
    """Velocities that can be reached within the prediction horizon, or within one control period (plain dynamic window)."""
    guidance: bool = True
    """Stall detection and guidance points around traps and fast obstacles."""
    right_hand: bool = True
    """Teammates give way to the right."""

    # dynamic window
    horizon_s: float | None = Field(default=None, gt=0, le=20)
    """Prediction horizon; unset: the time to the top speed, between 1.5 s and 4 s."""
    steps: int = Field(default=10, ge=2, le=50)
    """Of the prediction."""
    speed_samples: int = Field(default=11, ge=2, le=51)
    """Speeds in the window; the present speed and 0 come on top."""
    turn_samples: int = Field(default=21, ge=2, le=101)
    """Turn rates in the window; the present one, 0 and the one that turns to the goal come on top."""
    weight_heading: float = Field(default=0.5, ge=0)
    """Of pointing at the goal at the end of the horizon."""
    weight_clearance: float = Field(default=0.3, ge=0)
    """Of the free way before the first contact."""
    free_way_beyond_horizon: bool = False
    """The free way of a sample is measured beyond the horizon, straight on, to the way at top speed."""
    weight_velocity: float = Field(default=0.2, ge=0)
    """Of the wanted speed."""
    weight_avoidance: float = Field(default=0.4, ge=0)
    """Of giving way to the right, while that rule is on."""
    obstacle_range_m: float | None = Field(default=None, gt=0)
    """Obstacles beyond are ignored by the window; unset: what matters within the horizon."""
    braking_share: float = Field(default=0.8, gt=0, le=1)
    """Share of the acceleration limit that braking may assume."""
    lagging_margin: float = Field(default=0.2, ge=0, le=1)
    """A vehicle that follows its commands with a lag keeps more distance, by this share of what it flies during the lag: it cuts
    corners."""
    leave_first_m: float = Field(default=0.1, ge=0)
    """Deeper inside the margin of an obstacle than this, or than half of it, leaving comes before everything."""

    # guidance
    fan_half_angle_deg: float = Field(default=30.0, gt=0, le=90)
    """theta_r: half opening of the stall detector's rays around the course."""
    stall_cycles: int = Field(default=3, ge=1)
    """So many control periods with all rays blocked are a stall."""
    stall_progress_s: float = Field(default=5.0, gt=0)
    """No nearer to the goal by a fifth of the way at top speed within this time is a stall."""
    guidance_nodes: int = Field(default=2000, ge=100, le=20000)
    """Largest tree of one search."""
    guidance_nodes_a_step: int = Field(default=400, ge=10)
    """The search goes on in the next control period after so many new nodes."""
    guidance_free_cycles: int = Field(default=5, ge=1)
    """Guidance ends when the straight way has been free for so many control periods."""
    guidance_range_m: float = Field(default=100.0, gt=0)
    """R: a search reaches this far beyond own place, goal and known obstacles."""
    disc_memory_s: float = Field(default=600.0, ge=0)
    """How long a static disc that is no longer seen is remembered."""
    danger_distance: Literal["clearing", "paper"] = "clearing"
    """d_s of a fast obstacle: the way it makes while a vehicle clears its track, or the paper's formula."""

    # hunt
    hunting_radius_m: float | None = Field(default=None, gt=0)
    """r_h; unset: the slot radius of the capture rule. Never less than what bodies and separation need."""
    evader_radius_m: float = Field(default=0.25, ge=0)
    """r_d."""
    separation_m: float | None = Field(default=None, gt=0)
    """d_sep on the ring; unset: 2.5 body radii."""
    plan_period_s: float = Field(default=0.6, gt=0)
    """Between two plans."""
    plan_horizon_max_s: float = Field(default=600.0, gt=0)
    """The meeting is searched no further ahead than this, or three times the longest way at top speed."""
    close_ratio: float = Field(default=3.0, gt=1)
    """The ring closes, and assignments freeze, once all are within this many hunting radii of the target."""
    freeze_s: float = Field(default=5.0, ge=0)
    """Or so long before the meeting."""
    leaderless_s: float = Field(default=2.0, gt=0)
    """t_deg: after so long without a leader everybody plans alone from what it hears."""
    consensus: bool = True
    """False: nobody plans when the leader fails; its last plan is flown for ever (a baseline of the paper)."""
    target_stale_s: float = Field(default=2.0, gt=0)
    """Older knowledge of the target is only a place to go to."""
    target_lost_s: float = Field(default=10.0, gt=0)
    """After that the team spreads out and searches."""
    team_stale_s: float = Field(default=2.0, gt=0)
    """Teammates heard of longer ago do not take part."""
    plan_stale_s: float = Field(default=3600.0, gt=0)
    """A plan of the leader is flown for so long after it was last renewed."""

    @model_validator(mode="after")
    def _is_consistent(self) -> HuntingParameters:
        if self.target_lost_s <= self.target_stale_s:
            raise ValueError(f"target_lost_s = {self.target_lost_s} must be greater than target_stale_s = {self.target_stale_s}")
        if self.weight_heading + self.weight_clearance + self.weight_velocity <= 0.0:
            raise ValueError("weight_heading, weight_clearance and weight_velocity are all 0; at least one must be positive")
        return self
