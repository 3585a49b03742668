"""Who makes a vehicle follow the velocity that its planner decides, and with which gains."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flightapp.config.loading import Strict

Controller = Literal["autopilot", "aadrc-smc"]


class Tracking(Strict):
    """Of the controller `aadrc-smc` over the autopilot's velocity loop."""

    output: Literal["acceleration", "velocity"] = "acceleration"
    """Fed forward beside the decided velocity, or as another velocity setpoint for autopilots that take no acceleration."""
    velocity_gain_1_s: float = Field(default=1.8, gt=0, le=10)
    """Acceleration per velocity error of the autopilot's loop, where it does not answer for its MPC_XY_VEL_P_ACC."""
    vertical_gain_1_s: float = Field(default=4.0, gt=0, le=20)
    """The same for MPC_Z_VEL_P_ACC."""
    derivative_1_s: float = Field(default=4.0, gt=0, le=10)
    """Acceleration per velocity error of `aadrc-smc`."""
    switching_m_s2: float = Field(default=2.0, ge=0, le=10)
    """Of its sliding-mode term."""
    layer_m_s: float = Field(default=1.0, gt=0, le=10)
    """Half width of the boundary layer of that term."""
    observer_rad_s: float = Field(default=6.0, gt=0, le=15)
    """Bandwidth of the disturbance observer."""
    disturbance_max_m_s2: float = Field(default=4.0, gt=0, le=10)
    """As much of a disturbance is taken out."""
    actuator_s: float = Field(default=0.12, ge=0, le=1)
    """From commanded to flown acceleration."""
