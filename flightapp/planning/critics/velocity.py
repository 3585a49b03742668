"""Velocity: the faster, the better."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("void(f8[::1],f8[::1])")
def velocity_score(speeds_m_s: Array, out: Array) -> None:
    """Fill out (n,): the candidate's speed in m/s."""
    for c in range(out.shape[0]):
        out[c] = speeds_m_s[c]
