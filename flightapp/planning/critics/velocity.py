"""Velocity: the faster, the better."""

from __future__ import annotations

from flightapp.core.types import Array


def velocity(speeds_m_s: Array) -> Array:
    """The candidate's speed in m/s, (n,)."""
    return speeds_m_s
