"""The last word on the acceleration that goes beside a setpoint: the velocity and the yaw are the supervisor's and stay."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, Limits, Setpoint
from flightapp.safety.parameters import SafetyParameters


def with_feed_forward(sent: Setpoint, forward: Array | None, limits: Limits, parameters: SafetyParameters) -> Setpoint:
    """`sent`, what the supervisor lets through, with `forward` (3,) beside it, NED in m/s^2, shortened to the limits.

    None, or what is not finite, leaves `sent` as it is.
    """
    if forward is None or not np.isfinite(forward).all():
        return sent
    north, east, down = forward.tolist()
    planar = math.hypot(north, east)
    scale = limits.acceleration_max_m_s2 / planar if planar > limits.acceleration_max_m_s2 else 1.0
    vertical = parameters.vertical_acceleration_m_s2
    shortened = np.array((scale * north, scale * east, min(vertical, max(-vertical, down))))
    return Setpoint(sent.velocity_ned_m_s, sent.yaw_rad, shortened)
