"""Wanted speed: the nearer to it, the better."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("void(f8[::1],f8,f8[::1])")
def wanted_speed_score(speeds_m_s: Array, wanted_m_s: float, out: Array) -> None:
    """Fill out (n,): minus the difference of the candidate's speed from `wanted_m_s`, in m/s."""
    for c in range(out.shape[0]):
        out[c] = -abs(wanted_m_s - speeds_m_s[c])
