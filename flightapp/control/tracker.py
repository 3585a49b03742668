"""`aadrc-smc` over PX4's velocity loop: the decided velocity and an acceleration beside it that takes out wind and lag.

PX4 commands gain x (setpoint - velocity) + fed forward acceleration; so what is fed forward is what the law wants less what PX4
does by itself. The velocity setpoint stays what the planner decided: the guards judge that, and may drop the acceleration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from flightapp.config.profile import Profile
from flightapp.control.differentiator import differentiate
from flightapp.control.gains import Gains
from flightapp.control.law import decide, shortened
from flightapp.control.observer import APPLIED, BRAKE_AFTER_S, DISTURBANCE, GAP, STARTED, STATE_SIZE, observe
from flightapp.core.types import Array, Setpoint, VehicleState
from flightapp.vehicle.velocity_gains import VelocityGains

Variant = Literal["acceleration", "velocity"]
OF_VELOCITY = slice(3, 6)
RELEASE_S = 0.5
"""What pushes on the vehicle before is still the ground."""
NOTHING = np.zeros(3)


def make_tracker(profile: Profile) -> VelocityTracker:
    """As the profile says."""
    given, limits = profile.control.tracking, profile.limits
    law = Gains(
        derivative_1_s=given.derivative_1_s,
        switching_m_s2=given.switching_m_s2,
        layer_m_s=given.layer_m_s,
        observer_rad_s=given.observer_rad_s,
        schedule_1_m2=0.0,
        disturbance_max_m_s2=given.disturbance_max_m_s2,
        actuator_s=given.actuator_s,
        acceleration_max_m_s2=limits.acceleration_max_m_s2,
        vertical_max_m_s2=profile.safety.vertical_acceleration_m_s2,
        period_s=1.0 / profile.control.rate_min_hz,
        release_s=RELEASE_S,
        observes_velocity=1.0,
    )
    return VelocityTracker(TrackingGains(law, given.velocity_gain_1_s, given.vertical_gain_1_s, variant=given.output))


@dataclass(frozen=True, slots=True)
class TrackingGains:
    """What the tracker needs besides the law's gains."""

    law: Gains
    velocity_gain_1_s: float = 1.8
    """Of PX4's loop in the plane: MPC_XY_VEL_P_ACC."""
    vertical_gain_1_s: float = 4.0
    """MPC_Z_VEL_P_ACC."""
    differentiator_rad_s: float = 12.0
    damping: float = 0.9
    variant: Variant = "acceleration"


class VelocityTracker:
    """State of one vehicle. Each control period `watch`, then `wish` where a planner flies, then `note` what was sent."""

    def __init__(self, gains: TrackingGains) -> None:
        self._gains = gains
        self._law = gains.law.as_array()
        self._gain_1_s = np.array([gains.velocity_gain_1_s, gains.velocity_gain_1_s, gains.vertical_gain_1_s])
        self._state = np.zeros(STATE_SIZE)
        self._smooth = np.zeros(6)
        self._tracks = False
        self._reference = np.full(9, math.nan)
        self._command = np.zeros(3)
        self._velocity = np.zeros(3)
        self._dt_s = 0.0
        self._wished = False

    @property
    def disturbance_ned_m_s2(self) -> Array:
        """What is believed of the air's push and of everything else that the model leaves out."""
        return self._state[DISTURBANCE : DISTURBANCE + 3].copy()

    @property
    def loop(self) -> VelocityGains:
        """What it counts on the autopilot's velocity loop to do."""
        return VelocityGains(float(self._gain_1_s[0]), float(self._gain_1_s[2]))

    def fly_over(self, loop: VelocityGains) -> None:
        """The gains of the autopilot's velocity loop, where they are known better than by the profile."""
        self._gain_1_s = np.array([loop.planar_1_s, loop.planar_1_s, loop.vertical_1_s])

    def watch(self, own: VehicleState, dt_s: float) -> None:
        """The own state of this control period, `dt_s` after the last."""
        self._dt_s = dt_s
        self._velocity = own.velocity_ned_m_s
        observe(self._state, self._law, dt_s, own.position_ned_m, own.velocity_ned_m_s)

    def wish(self, decided: Setpoint) -> Setpoint:
        """`decided` as the supervisor is to be asked for it; unchanged where the own state has been unknown for too long."""
        state, decided_m_s = self._state, decided.velocity_ned_m_s
        if state[STARTED] == 0.0 or state[GAP] > BRAKE_AFTER_S or not np.isfinite(decided_m_s).all():
            return decided
        self._wished = True
        if not self._tracks:
            self._smooth[:3], self._smooth[3:] = decided_m_s, 0.0
        differentiate(self._smooth, decided_m_s, self._gains.differentiator_rad_s, self._gains.damping, self._dt_s)
        self._reference[OF_VELOCITY] = decided_m_s
        self._reference[6:] = self._smooth[3:]
        decide(state, self._law, self._reference, NOTHING, self._command)
        if self._gains.variant == "velocity":
            return Setpoint(self._velocity + self._command / self._gain_1_s, decided.yaw_rad)
        forward, against = np.zeros(3), self._against()
        shortened(self._command - self._gain_1_s * (decided_m_s - self._velocity), forward, self._gains.law.acceleration_max_m_s2)
        forward[2] = min(self._gains.law.vertical_max_m_s2, max(-self._gains.law.vertical_max_m_s2, forward[2]))
        return Setpoint(decided_m_s, decided.yaw_rad, forward - against, against)

    def steady(self, hover: Setpoint) -> Setpoint:
        """`hover` with the compensation of the wind, so that it neither comes nor goes with the planner."""
        if self._gains.variant == "velocity" or self._state[STARTED] == 0.0 or self._state[GAP] > BRAKE_AFTER_S:
            return hover
        return replace(hover, compensation_ned_m_s2=self._against())

    def _against(self) -> Array:
        """No more than the guards let through: what is beyond would be dropped as a whole."""
        against = np.zeros(3)
        shortened(-self._state[DISTURBANCE : DISTURBANCE + 3], against, self._gains.law.acceleration_max_m_s2)
        against[2] = min(self._gains.law.vertical_max_m_s2, max(-self._gains.law.vertical_max_m_s2, against[2]))
        return against

    def note(self, sent: Setpoint) -> None:
        """What the supervisor sent: the observer believes in that, not in the wish."""
        self._tracks, self._wished = self._wished, False
        told = self._gain_1_s * (sent.velocity_ned_m_s - self._velocity)
        forward = sent.fed_forward_ned_m_s2
        if forward is not None:
            told = told + forward
        shortened(told, self._state[APPLIED : APPLIED + 3], self._gains.law.acceleration_max_m_s2)
