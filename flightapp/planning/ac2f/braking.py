"""Braking distance as a speed limit: the one formula behind every "can still stop" in this package."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled


@compiled("f8(f8,f8,f8)")
def braking_speed_m_s(gap_m: float, deceleration_m_s2: float, reaction_s: float) -> float:
    """Highest speed that stops within `gap_m` after `reaction_s` at `deceleration_m_s2`: v t + v^2 / (2 a) = gap."""
    if gap_m <= 0.0:
        return 0.0
    return deceleration_m_s2 * (math.sqrt(reaction_s * reaction_s + 2.0 * gap_m / deceleration_m_s2) - reaction_s)
