"""`aadrc-smc` over PX4's velocity loop: beside the velocity that the guards let through, an acceleration that makes it flown.

PX4 commands gain x (setpoint - velocity) + fed forward acceleration; so what is fed forward is what the law wants less what PX4
does by itself. It follows what is *sent*: most decisions of a pursuit are changed by a guard, at least by the limits of
acceleration and jerk. And it never takes away from PX4's own pull, or braking hard would become braking at the profile's limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flightapp.config.profile import Profile
from flightapp.control.differentiator import differentiate
from flightapp.control.gains import Gains
from flightapp.control.law import decide, limited_sum, shortened
from flightapp.control.observer import APPLIED, BRAKE_AFTER_S, DISTURBANCE, GAP, STARTED, STATE_SIZE, TRACKING, observe
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
    differentiator_rad_s: float = 25.0
    """Of how the velocity that is sent changes: that is known exactly, so it may be fast."""
    damping: float = 0.9
    variant: Variant = "acceleration"


class VelocityTracker:
    """State of one vehicle. Each control period `watch`, `wish` where a planner flies, `forward` for what the guards let through,
    and `note` what was sent. Nothing is fed forward before the first `begin`.
    """

    def __init__(self, gains: TrackingGains) -> None:
        self._gains = gains
        self._law = gains.law.as_array()
        self._gain_1_s = np.array([gains.velocity_gain_1_s, gains.velocity_gain_1_s, gains.vertical_gain_1_s])
        self._state = np.zeros(STATE_SIZE)
        self._smooth = np.zeros(6)
        self._follows = False
        self._tracked = False
        self._reference = np.full(9, math.nan)
        self._command = np.zeros(3)
        self._velocity = np.zeros(3)
        self._dt_s = 0.0

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

    def begin(self) -> None:
        """From now on there is something to follow. What was believed before, on the ground and in the climb, is forgotten."""
        self._state[:] = 0.0
        self._follows = True
        self._tracked = False

    def wish(self, decided: Setpoint) -> Setpoint:
        """`decided`, or in its place the velocity setpoint that makes the autopilot fly it, which the guards judge then.

        For autopilots that take no acceleration beside a velocity.
        """
        decided_m_s = decided.velocity_ned_m_s
        if self._gains.variant == "acceleration" or not self._is_able or not np.isfinite(decided_m_s).all():
            return decided
        self._decide(decided_m_s)
        shortened(self._state[TRACKING : TRACKING + 3], self._command, self._gains.law.acceleration_max_m_s2)
        return Setpoint(self._velocity + self._command / self._gain_1_s, decided.yaw_rad)

    def forward(self, sent: Setpoint) -> Array | None:
        """(3,): acceleration to go beside `sent`, which the guards have let through; None where there is none to be had.

        An acceleration that `sent` has is taken for the one that its velocity needs; else that is found from how it changes.
        """
        velocity_m_s = sent.velocity_ned_m_s
        if self._gains.variant == "velocity" or not self._is_able or not np.isfinite(velocity_m_s).all():
            return None
        self._decide(velocity_m_s, sent.acceleration_ned_m_s2)
        limit = self._gains.law.acceleration_max_m_s2
        own, both = np.zeros(3), np.zeros(3)
        pull = self._gain_1_s * (velocity_m_s - self._velocity)
        shortened(pull, own, limit)
        limited_sum(pull, self._state[TRACKING : TRACKING + 3] - pull, both, limit)
        return both - own

    @property
    def _is_able(self) -> bool:
        """Whether the own state has been known for long enough and not been lost for too long."""
        return self._follows and self._state[STARTED] > 0.0 and self._state[GAP] <= BRAKE_AFTER_S

    def _decide(self, velocity_m_s: Array, acceleration_m_s2: Array | None = None) -> None:
        """Into the state: the acceleration that following `velocity_m_s` takes now, unlimited."""
        gains, velocity_m_s = self._gains, np.ascontiguousarray(velocity_m_s, dtype=np.float64)
        if not self._tracked:
            self._smooth[:3], self._smooth[3:] = velocity_m_s, 0.0
        self._tracked = True
        differentiate(self._smooth, velocity_m_s, gains.differentiator_rad_s, gains.damping, self._dt_s)
        self._reference[OF_VELOCITY] = velocity_m_s
        self._reference[6:] = self._smooth[3:] if acceleration_m_s2 is None else acceleration_m_s2
        decide(self._state, self._law, self._reference, NOTHING, self._command)

    def note(self, sent: Setpoint) -> None:
        """What was sent in the end: the observer believes in that, not in the wish."""
        told = self._gain_1_s * (sent.velocity_ned_m_s - self._velocity)
        forward = sent.acceleration_ned_m_s2
        if forward is not None:
            told = told + forward
        shortened(told, self._state[APPLIED : APPLIED + 3], self._gains.law.acceleration_max_m_s2)
