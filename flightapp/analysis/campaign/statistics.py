"""Shares of successful runs: how sure they are, and whether two of them differ."""

from __future__ import annotations

import math

Z_95 = 1.959963984540054
"""97.5 % quantile of the normal distribution: 95 % two-sided."""


def wilson_interval(successes: int, runs: int, z: float = Z_95) -> tuple[float, float]:
    """Wilson score interval of a share of `runs` >= 1, within [0, 1] (Wilson 1927)."""
    share, z2 = successes / runs, z * z
    centre = (share + z2 / (2 * runs)) / (1 + z2 / runs)
    half = z / (1 + z2 / runs) * math.sqrt(share * (1 - share) / runs + z2 / (4 * runs * runs))
    # at 0 and 1 the ends coincide with the share, which rounding must not miss
    return max(0.0, min(share, centre - half)), min(1.0, max(share, centre + half))


def two_proportion_p_value(successes: int, runs: int, other_successes: int, other_runs: int) -> float:
    """Two-sided p-value of the pooled two-proportion z-test; 1 where both shares are 0 or both are 1."""
    pooled = (successes + other_successes) / (runs + other_runs)
    variance = pooled * (1 - pooled) * (1 / runs + 1 / other_runs)
    if variance == 0.0:
        return 1.0
    z = (successes / runs - other_successes / other_runs) / math.sqrt(variance)
    return math.erfc(abs(z) / math.sqrt(2))
