"""Parameters of the evader policies."""

from __future__ import annotations

import math

from pydantic import Field, field_validator

from flightapp.planning.parameters import StrategyParameters


class HoverParameters(StrategyParameters):
    """The policy that stands still has none."""


class StraightParameters(StrategyParameters):
    """Straight to the nearest boundary point, with noise on the heading."""

    heading_noise_deg: float = Field(default=5.0, ge=0, le=90)
    """Standard deviation of the heading error."""
    noise_period_s: float = Field(default=0.5, gt=0)
    """How long one heading error lasts."""


class BoundarySeekingParameters(StrategyParameters):
    """Towards the boundary, around obstacles and, weakly, away from pursuers."""

    field_gain_m2: float = Field(default=0.25, ge=0)
    """Repulsion of obstacles, relative to an attraction of 1, at 1 m from the inflated edge."""
    field_influence_m: float = Field(default=2.5, gt=0)
    """Distance from the inflated edge within which an obstacle repels."""
    field_repulsion_max: float = Field(default=0.9, ge=0)
    """Cap of the summed repulsion of obstacles."""
    pursuer_gain: float = Field(default=0.3, ge=0)
    """Largest repulsion of a pursuer, relative to an attraction of 1."""
    pursuer_influence_m: float = Field(default=6.0, gt=0)
    """Distance within which a pursuer repels."""
    pursuer_distance_m: float = Field(default=1.2, ge=0)
    """Distance that the evader keeps from a pursuer's centre."""
    braking_share: float = Field(default=0.8, gt=0, le=1)
    """Share of the acceleration limit that braking may assume."""
    reaction_s: float = Field(default=0.3, ge=0)
    """Time until the vehicle brakes."""
    obstacle_range_m: float = Field(default=15.0, gt=0)
    """Obstacles beyond are ignored."""


class WaypointsParameters(StrategyParameters):
    """From one point to the next, then stand at the last."""

    waypoints: tuple[float, ...] = Field(min_length=2)
    """north, east, north, east, ... in m."""
    arrival_m: float = Field(default=1.0, gt=0)
    """A waypoint counts as reached within this distance."""

    @field_validator("waypoints")
    @classmethod
    def _are_pairs(cls, waypoints: tuple[float, ...]) -> tuple[float, ...]:
        if len(waypoints) % 2 or not all(math.isfinite(value) for value in waypoints):
            raise ValueError("must be pairs north, east, north, east, ...")
        return waypoints
