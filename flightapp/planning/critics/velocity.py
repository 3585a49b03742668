"""Velocity: the faster, the better."""

from __future__ import annotations

from flightapp.core.types import Array


def velocity(speeds_m_s: Array, out: Array) -> None:
    """Fill out (n,): the candidate's speed in m/s."""
    out[:] = speeds_m_s
