"""How well a depth camera places what it sees."""

from __future__ import annotations

RANGE_SIGMA_MIN_M = 0.15
RANGE_SIGMA_1_M = 0.006
ACROSS_SIGMA_MIN_M = 0.1
ACROSS_SIGMA_RAD = 0.01


def sighting_sigma_m(distance_m: float) -> tuple[float, float]:
    """Standard deviations along and across the line of sight: stereo's range error grows with the distance squared."""
    return RANGE_SIGMA_MIN_M + RANGE_SIGMA_1_M * distance_m**2, ACROSS_SIGMA_MIN_M + ACROSS_SIGMA_RAD * distance_m
