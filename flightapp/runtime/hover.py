"""Braking and standing still, and the height loop that PX4's velocity mode does not close by itself."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, Decision, Setpoint, VehicleState

GAIN_1_S = 0.8
SPEED_MAX_M_S = 1.0
AT_REST_M_S = 0.6
"""Below this speed a braking vehicle chooses the place to hover at."""


class Hover:
    """Mission frame NED; `height_m` above the datum is the mission height, which it keeps unless told otherwise."""

    def __init__(
        self, height_m: float, climb_rate_max_m_s: float, altitude_gain_1_s: float, sink_rate_max_m_s: float | None = None
    ) -> None:
        """Without a sink rate it sinks as fast as it climbs."""
        self._down_m = -height_m
        self._climb_rate_max_m_s = climb_rate_max_m_s
        self._sink_rate_max_m_s = climb_rate_max_m_s if sink_rate_max_m_s is None else sink_rate_max_m_s
        self._altitude_gain_1_s = altitude_gain_1_s
        self._place: Array | None = None
        self._kept_down_m = self._down_m

    @property
    def at_rest(self) -> bool:
        """True once the vehicle has come to rest and keeps its place."""
        return self._place is not None

    def restart(self) -> None:
        """Brake anew at the next setpoint."""
        self._place = None

    def keep_height_of(self, own: VehicleState) -> None:
        """Stand where the vehicle is now, whatever lies below."""
        self._kept_down_m = float(own.position_ned_m[2])

    def keep_mission_height(self) -> None:
        """Stand at the mission height again."""
        self._kept_down_m = self._down_m

    def setpoint(self, own: VehicleState, yaw_rad: float) -> Setpoint:
        """Brake first, then stay where the vehicle came to rest."""
        down = self._towards_m_s(self._kept_down_m, own)
        if self._place is None:
            if math.hypot(own.velocity_ned_m_s[0], own.velocity_ned_m_s[1]) > AT_REST_M_S:
                return Setpoint(np.array([0.0, 0.0, down]), yaw_rad)
            self._place = own.position_ned_m.copy()
        velocity = GAIN_1_S * (self._place - own.position_ned_m)
        speed = math.hypot(velocity[0], velocity[1])
        if speed > SPEED_MAX_M_S:
            velocity[:2] *= SPEED_MAX_M_S / speed
        velocity[2] = down
        return Setpoint(velocity, yaw_rad)

    def down_velocity_m_s(self, own: VehicleState) -> float:
        """Down velocity that closes the error of the mission height."""
        return self._towards_m_s(self._down_m, own)

    def _towards_m_s(self, down_m: float, own: VehicleState) -> float:
        wanted = self._altitude_gain_1_s * (down_m - float(own.position_ned_m[2]))
        return max(-self._climb_rate_max_m_s, min(self._sink_rate_max_m_s, wanted))


def wish_of(decision: Decision, hover: Hover, own: VehicleState, *, feed_forward: bool) -> Setpoint:
    """A decision as the setpoint that the supervisor is asked for: with the height loop, and the acceleration if it is flown."""
    velocity = decision.velocity_ned_m_s.astype(np.float64, copy=True)
    if not decision.flies_height:
        velocity[2] += hover.down_velocity_m_s(own)
    return Setpoint(velocity, decision.yaw_rad, decision.acceleration_ned_m_s2 if feed_forward else None)
