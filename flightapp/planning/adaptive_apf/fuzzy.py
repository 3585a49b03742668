"""The fuzzy speed gain in closed form: zero-order Sugeno, product inference, Gaussian memberships (section 2.7)."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.space.bodies import NUMBER

DISTANCES_M = (5.0, 10.0, 15.0)
ANGLES_DEG = (0.0, 90.0, 180.0)
SIGMA_M, SIGMA_DEG = 2.123, 38.22
"""Neighbouring memberships cross at one half."""
PRINTED = (0.05, 0.05, 0.10, 0.15, 0.10, 0.20, 0.15, 0.20, 0.25)
MONOTONE = (0.05, 0.05, 0.10, 0.10, 0.15, 0.20, 0.15, 0.20, 0.25)
"""Gain by distance (rows) and angle: LA, MMA, MA, HHA, HA are 0.05, 0.10, 0.15, 0.20, 0.25."""


@compiled(NUMBER(NUMBER, NUMBER, NUMBER))
def speed_gain(distance_m: float, angle_deg: float, printed: float) -> float:
    """Share by which the speed changes, for an activation distance and the angle between the velocities of vehicle and body."""
    distance = min(15.0, max(5.0, distance_m))
    angle = min(180.0, max(0.0, angle_deg))
    total = weighted = 0.0
    for row in range(3):
        near = (distance - DISTANCES_M[row]) / SIGMA_M
        for column in range(3):
            turned = (angle - ANGLES_DEG[column]) / SIGMA_DEG
            weight = math.exp(-0.5 * (near * near + turned * turned))
            value = PRINTED[3 * row + column] if printed != 0.0 else MONOTONE[3 * row + column]
            total += weight
            weighted += weight * value
    return weighted / total
