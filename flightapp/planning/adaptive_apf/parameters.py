"""Every number of the adaptive potential field in flight, with its unit; vehicle limits come with `limits`."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flightapp.core.types import Limits
from flightapp.planning.adaptive_apf.gains import Gains
from flightapp.planning.capture import CaptureRule
from flightapp.planning.parameters import StrategyParameters


class AdaptiveApfParameters(StrategyParameters):
    """Parameters of the strategy `adaptive-apf`. Defaults are those of its specification where a comment says nothing else."""

    capture: CaptureRule = CaptureRule()
    """The mission's capture section."""
    control_period_s: float = Field(default=0.1, gt=0)
    """Assumed where an observation says none."""
    modules: str = Field(default="ABCD", pattern="^A?B?C?D?$")
    """A: repulsion that vanishes at the goal; B: escape from minima; C: steering and braking before predicted collisions;
    D: activation distance and speed that follow the threat."""
    law: Literal["field", "double-integrator"] = "field"
    """The velocity along the force, or the force as acceleration with only approaching bodies repelling (IAPF-style)."""
    damping_1_s: float | None = Field(default=None, gt=0)
    """Of the double integrator; None: so much that the full attraction flies at the vehicle's top speed."""
    safety_filter: Literal["braking", "barrier", "off"] = "braking"
    """Neither the source's nor a part of it: the last word over the velocity, by what can be braked before each body or by a
    control barrier function of first order."""
    lead: bool = True
    """Fly at where the target can be met; False: at where it is."""
    vertical: Literal["free", "hold"] = "free"
    """free: to the target's height and over or under bodies, where the heights of all bodies in range are known."""

    attraction_1_s2: float = Field(default=1.5, gt=0)
    attraction_reach_m: float = Field(default=4.0, gt=0)
    """Farther from the goal, attraction does not grow."""
    repulsion_m4_s2: float = Field(default=8.0, ge=0)
    goal_power: float = Field(default=2.0, ge=2)
    """With less than 2 the force does not vanish at the goal."""
    goal_scale_min_m: float = Field(default=4.0, gt=0)
    """Nearer to the goal than this, or than twice the activation distance, repulsion shrinks."""
    reach_m: float = Field(default=4.0, gt=0)
    """Activation distance without module D."""
    reach_min_m: float = Field(default=0.5, ge=0)
    reach_max_m: float = Field(default=15.0, gt=0)
    """Also the range within which bodies are looked at."""
    horizon_s: float = Field(default=5.0, gt=0)
    """Collisions later than this are not predicted."""
    margin_m: float | None = Field(default=None, ge=0)
    """Distance that is kept from bodies; None: the vehicle's safety margin."""
    steering_share: float = Field(default=0.8, gt=0, le=1)
    """Share of the acceleration limit for steering."""
    braking_share: float = Field(default=0.6, gt=0, le=1)
    return_law: Literal["off", "damped", "zones"] = "off"
    """Return to the line from where the target was first seen to where it is: not in free pursuit. `zones`: the source's form."""
    return_1_s2: float = Field(default=1.0, gt=0)
    """Of the damped return."""
    barrier_1_s: float = Field(default=1.0, gt=0)
    """alpha of the barrier function, and how fast a margin is left that was entered."""
    goal_margin_max_m: float = Field(default=5.0, gt=0)
    """A goal inside a body is moved out by at most this."""
    stuck_s: float = Field(default=5.0, gt=0)
    """After three escapes in vain it hovers and says `stuck` this long, unless the way becomes free; then it tries again."""
    slot_gain_per_s: float = Field(default=1.5, gt=0)
    """Where the team encircles: approach speed to the own place per metre of way left."""

    reaction_s: float = Field(default=0.55, ge=0)
    """Time from a decision until the vehicle brakes."""
    response_lag_s: float = Field(default=0.45, ge=0)
    """Lag of the velocity loop; the field is that of where it puts the vehicle."""
    command_blend: float = Field(default=0.08, ge=0, le=1)
    """Changes are limited against this share of the measured velocity and the rest of the last command."""
    target_stale_s: float = Field(default=2.0, gt=0)
    target_lost_s: float = Field(default=10.0, gt=0)
    team_stale_s: float = Field(default=2.0, gt=0)
    prediction_max_s: float = Field(default=1.0, ge=0)
    """What is older is moved on with its velocity over no more than this."""
    lead_max_s: float = Field(default=15.0, gt=0)
    vehicle_disc_m: float = Field(default=0.5, ge=0)
    """A small disc this near to another vehicle is that vehicle."""
    vehicle_radius_max_m: float = Field(default=0.6, ge=0)
    """Larger discs are never taken for a vehicle."""

    def margin(self, limits: Limits) -> float:
        return limits.safety_margin_m if self.margin_m is None else self.margin_m

    def gains(self, limits: Limits) -> Gains:
        """As the kernels read them."""
        acceleration = limits.acceleration_max_m_s2
        a, c, d = (1.0 if module in self.modules else 0.0 for module in "ACD")
        return Gains(
            attraction_1_s2=self.attraction_1_s2,
            attraction_reach_m=self.attraction_reach_m,
            repulsion=self.repulsion_m4_s2,
            gap_min_m=0.05,
            force_max_m_s2=4.0 * acceleration,
            goal_aware=a,
            goal_power=self.goal_power,
            goal_bounded=1.0,
            goal_scale_min_m=self.goal_scale_min_m,
            predictive=c,
            kinematic=0.0,
            steering_m_s2=self.steering_share * acceleration,
            braking_m_s2=self.braking_share * acceleration,
            speed_m_s=limits.speed_max_m_s,
            horizon_s=self.horizon_s,
            delay_s=self.reaction_s,
            body_radius_m=limits.body_radius_m,
            margin_m=self.margin(limits),
            vertical_weight=1.0,
            return_1_s2=0.0 if self.return_law == "off" else self.return_1_s2,
            return_max_m_s2=0.3 * acceleration,
            return_zones=1.0 if self.return_law == "zones" else 0.0,
            adaptive=d,
            printed=0.0,
            reach_m=self.reach_m,
            reach_min_m=self.reach_min_m,
            reach_max_m=self.reach_max_m,
            obstacle_s=0.0,
            only_closing=1.0 if self.law == "double-integrator" else 0.0,
        )

    @property
    def full_attraction_m_s2(self) -> float:
        return self.attraction_1_s2 * self.attraction_reach_m

    @property
    def holds(self) -> bool:
        """Whether the vehicle is to stay near the target rather than to touch it."""
        return self.capture.mode != "first"

    @property
    def filter_form(self) -> float:
        return {"off": 0.0, "barrier": 1.0, "braking": 2.0}[self.safety_filter]
