"""What the guards in the plane have in common: they state bounds, and alone they project onto their own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.velocity_bounds import EPSILON, Planar, VelocityBound, project


class SpatialGuard(Protocol):
    """A guard whose rule is a set of half-planes of the planar velocity."""

    @property
    def name(self) -> str: ...

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:
        """Bounds that a velocity no faster than `speed_m_s` can break; `wish` says which way the vehicle wants to go."""
        ...


def check_alone(guard: SpatialGuard, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
    """The verdict of one spatial guard without the others."""
    north, east, down = setpoint.velocity_ned_m_s.tolist()
    wish = (north, east)
    bounds = guard.bounds(wish, max(math.hypot(*wish), context.limits.speed_max_m_s), context)
    broken = breaking(wish, bounds)
    if not broken:
        return GuardVerdict(setpoint)
    allowed = project(wish, bounds, max(math.hypot(*wish), context.limits.speed_max_m_s))
    return GuardVerdict(with_velocity(setpoint, *allowed, down), worst(wish, broken).reason())


def breaking(wish: Planar, bounds: Sequence[VelocityBound]) -> list[VelocityBound]:
    """The bounds that `wish` breaks."""
    return [bound for bound in bounds if bound.excess_m_s(wish) > EPSILON]


def worst(wish: Planar, broken: Sequence[VelocityBound]) -> VelocityBound:
    """The bound that `wish` breaks most; the first of equals."""
    return max(broken, key=lambda bound: bound.excess_m_s(wish))
