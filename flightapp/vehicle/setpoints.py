"""From the app's setpoint to the wire, without waiting."""

from __future__ import annotations

import math
from typing import Any

from mavsdk.plugins.offboard import AccelerationNed, Offboard, PositionNedYaw, VelocityNedYaw

from flightapp.core.types import Setpoint


class Setpoints:
    """Sends through MAVSDK's offboard plug-in, which repeats the last one at 20 Hz until another mode is reported.

    Velocity with acceleration goes out as position, velocity and acceleration with a position of NaN: MAVSDK has no call without
    a position, and PX4 since 1.12 reads NaN as "not said". MAVLink sent past the plug-in could leave the position out by its type
    mask, but the plug-in would then go on repeating its own last setpoint in between.
    """

    def __init__(self, offboard: Offboard, acceleration_feed_forward: bool) -> None:
        self._offboard: Any = offboard
        self._acceleration_feed_forward = acceleration_feed_forward

    def send(self, setpoint: Setpoint) -> None:
        """Send now. ValueError for what is not finite: MAVSDK would pass it on, and PX4 would brake."""
        north, east, down = (float(value) for value in setpoint.velocity_ned_m_s)
        if not math.isfinite(north + east + down + setpoint.yaw_rad):
            raise ValueError(f"setpoint is not finite: velocity {(north, east, down)} m/s, yaw {setpoint.yaw_rad} rad")
        yaw_deg = math.degrees(setpoint.yaw_rad)
        velocity = VelocityNedYaw(north, east, down, yaw_deg)
        fed_forward = setpoint.acceleration_ned_m_s2
        if fed_forward is None or not self._acceleration_feed_forward:
            self._offboard.set_velocity_ned(velocity)
            return
        forward = tuple(float(value) for value in fed_forward)
        if not math.isfinite(sum(forward)):
            raise ValueError(f"setpoint is not finite: acceleration {forward} m/s2")
        unsaid = PositionNedYaw(math.nan, math.nan, math.nan, yaw_deg)
        self._offboard.set_position_velocity_acceleration_ned(unsaid, velocity, AccelerationNed(*forward))
