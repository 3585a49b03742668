"""Setpoints derived from setpoints: what guards hand on when they change something."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Setpoint
from flightapp.safety.api import SafetyContext


def with_velocity(setpoint: Setpoint, north_m_s: float, east_m_s: float, down_m_s: float) -> Setpoint:
    """`setpoint` at another velocity; an acceleration that belonged to the old one is dropped."""
    return Setpoint(np.array([north_m_s, east_m_s, down_m_s]), setpoint.yaw_rad)


def held_yaw_rad(context: SafetyContext) -> float:
    """The yaw to hold: the last one sent, else the own one, else north; always finite."""
    if context.previous is not None and math.isfinite(context.previous.yaw_rad):
        return context.previous.yaw_rad
    return context.own.yaw_rad if math.isfinite(context.own.yaw_rad) else 0.0


def standstill(context: SafetyContext) -> Setpoint:
    """Zero velocity, yaw held."""
    return Setpoint(np.zeros(3), held_yaw_rad(context))
