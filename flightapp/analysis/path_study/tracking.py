"""A planned flight flown by a plain vehicle: a double integrator with limits and the lag of an autopilot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.path_planning.trajectory import Trajectory

STEP_S = 0.02
LAG_S = 0.1
DELAY_STEPS = 1
POSITION_GAIN_1_S2, VELOCITY_GAIN_1_S = 4.0, 4.0
"""Default gains of the specification of RRT*-APF, section 2.6, for this lag and delay."""
SETTLING_S = 2.0


@dataclass(frozen=True, slots=True)
class Flown:
    """positions_ned_m (n, 3), one every STEP_S; error_m: the greatest distance to where it was to be; limited: the share of
    steps in which the acceleration limit was reached.
    """

    positions_ned_m: Array
    error_m: float
    limited: float


def fly(trajectory: Trajectory, acceleration_max_m_s2: float) -> Flown:
    """Follow `trajectory` with position, velocity and acceleration as its feed-forward."""
    count = int((trajectory.duration_s + SETTLING_S) / STEP_S) + 1
    position = trajectory.at(0.0).position_ned_m.copy()
    velocity, acceleration = np.zeros(3), np.zeros(3)
    waiting = [np.zeros(3)] * DELAY_STEPS
    places, error, limited = np.empty((count, 3)), 0.0, 0
    for k in range(count):
        wanted = trajectory.at(k * STEP_S)
        places[k] = position
        error = max(error, float(np.linalg.norm(position - wanted.position_ned_m)))
        asked = (
            wanted.acceleration_ned_m_s2
            + POSITION_GAIN_1_S2 * (wanted.position_ned_m - position)
            + VELOCITY_GAIN_1_S * (wanted.velocity_ned_m_s - velocity)
        )
        size = float(np.linalg.norm(asked))
        if size > acceleration_max_m_s2:
            asked *= acceleration_max_m_s2 / size
            limited += 1
        waiting.append(asked)
        acceleration = acceleration + (1.0 - np.exp(-STEP_S / LAG_S)) * (waiting.pop(0) - acceleration)
        position = position + STEP_S * velocity + 0.5 * STEP_S * STEP_S * acceleration
        velocity = velocity + STEP_S * acceleration
    return Flown(places, error, limited / count)
