"""Parameters of the evader policies."""

from __future__ import annotations

import math
from pathlib import Path

from pydantic import Field, field_validator, model_validator

from flightapp.planning.parameters import StrategyParameters

Area = tuple[float, float, float, float]
"""Least north, least east, greatest north, greatest east, m."""


def _with_extent(area: Area | None) -> Area | None:
    if area is not None and (area[0] >= area[2] or area[1] >= area[3]):
        raise ValueError("must be least north, least east, greatest north, greatest east")
    return area


class HoverParameters(StrategyParameters):
    """The policy that stands still has none."""


class StraightParameters(StrategyParameters):
    """Straight to the nearest boundary point, with noise on the heading."""

    heading_noise_deg: float = Field(default=5.0, ge=0, le=90)
    """Standard deviation of the heading error."""
    noise_period_s: float = Field(default=0.5, gt=0)
    """How long one heading error lasts."""


class AvoidingParameters(StrategyParameters):
    """How an evader keeps clear of obstacles and of the pursuers."""

    field_gain_m2: float = Field(default=0.25, ge=0)
    """Repulsion of obstacles, relative to an attraction of 1, at 1 m from the inflated edge."""
    field_influence_m: float = Field(default=2.5, gt=0)
    """Distance from the inflated edge within which an obstacle repels."""
    field_repulsion_max: float = Field(default=0.9, ge=0)
    """Cap of the summed repulsion of obstacles."""
    pursuer_distance_m: float = Field(default=1.2, ge=0)
    """Distance that the evader keeps from a pursuer's centre."""
    braking_share: float = Field(default=0.8, gt=0, le=1)
    """Share of the acceleration limit that braking may assume."""
    reaction_s: float = Field(default=0.3, ge=0)
    """Time until the vehicle brakes."""
    obstacle_range_m: float = Field(default=15.0, gt=0)
    """Obstacles beyond are ignored."""


class BoundarySeekingParameters(AvoidingParameters):
    """Towards the boundary, around obstacles and, weakly, away from pursuers."""

    pursuer_gain: float = Field(default=0.3, ge=0)
    """Largest repulsion of a pursuer, relative to an attraction of 1."""
    pursuer_influence_m: float = Field(default=6.0, gt=0)
    """Distance within which a pursuer repels."""


class ClimbAndDiveParameters(BoundarySeekingParameters):
    """Boundary-seeking, up and down on the way. Heights are metres above the datum."""

    height_low_m: float = Field(default=3.0, ge=0)
    """Where a dive ends."""
    height_high_m: float = Field(default=12.0, gt=0)
    """Where a climb ends."""
    climb_rate_m_s: float = Field(default=1.5, gt=0)
    """Of climbs and dives, at most the vehicle's limit."""
    climb_acceleration_m_s2: float = Field(default=2.0, gt=0)
    """Of their beginnings and ends."""
    dodge_m: float = Field(default=4.0, ge=0)
    """A pursuer that comes nearer than this makes it turn from climbing to diving or back; 0: none does."""

    @model_validator(mode="after")
    def _is_band(self) -> ClimbAndDiveParameters:
        if self.height_low_m >= self.height_high_m:
            raise ValueError(f"height_low_m = {self.height_low_m} must be less than height_high_m = {self.height_high_m}")
        return self


class ManoeuvringParameters(AvoidingParameters):
    """Towards the boundary, with manoeuvres; each is off unless it is asked for."""

    pursuer_distance_m: float = Field(default=0.0, ge=0)
    """Distance that the evader keeps from a pursuer's centre, on top of fleeing."""
    weave_deg: float = Field(default=0.0, ge=0, le=80)
    """So far the course swings to both sides."""
    weave_period_s: float = Field(default=20.0, gt=0)
    """From one side to the other and back."""
    flee_within_m: float = Field(default=0.0, ge=0)
    """While a pursuer is nearer than this, it flees from all, from each with the inverse square of its distance."""
    speed_before_m_s: float | None = Field(default=None, gt=0)
    """Of a target that grows faster: its speed until then; unset: the vehicle's limit."""
    jump_s: float = Field(default=60.0, ge=0)
    """From this time after its start on it flies as fast as the vehicle can."""


class VoronoiCentroidParameters(AvoidingParameters):
    """To the centroid of the own Voronoi cell, drawn towards the boundary."""

    boundary_bias: float = Field(default=0.5, ge=0)
    """Attraction of the boundary, relative to an attraction of 1 by a centroid that is far away."""
    reach_m: float = Field(default=10.0, gt=0)
    """Half side of the square around the evader that bounds its cell where no area is given."""
    area_m: Area | None = None
    """The flight area that bounds the cell: least north, least east, greatest north, greatest east."""
    settling_s: float = Field(default=0.5, gt=0)
    """Nearer to the centroid than this at full speed, the attraction lessens in proportion: no chatter there."""

    _has_extent = field_validator("area_m")(_with_extent)


class ReactingParameters(AvoidingParameters):
    """Of the policies that flee in some direction."""

    pursuer_distance_m: float = Field(default=0.0, ge=0)
    """Distance that the evader keeps from a pursuer's centre, on top of fleeing."""
    area_m: Area | None = None
    """The area that it does not leave by itself: least north, least east, greatest north, greatest east."""
    edge_s: float = Field(default=0.5, gt=0)
    """It turns along the area's edge this long before it would cross it."""

    _has_extent = field_validator("area_m")(_with_extent)


class GoalSeekerParameters(ReactingParameters):
    """To a goal, weakly away from near pursuers."""

    goal_m: tuple[float, float] = (0.0, 0.0)
    """north, east."""
    arrival_m: float = Field(default=0.5, gt=0)
    """It stands within this distance of the goal."""
    pursuer_gain: float = Field(default=0.8, ge=0)
    """Largest repulsion of a pursuer, relative to an attraction of 1."""
    pursuer_influence_m: float = Field(default=6.0, gt=0)
    """Distance within which a pursuer repels."""


class RandomWaypointsParameters(AvoidingParameters):
    """Random places of an area, one after the other."""

    area_m: Area = (-10.0, -10.0, 10.0, 10.0)
    """Least north, least east, greatest north, greatest east."""
    arrival_m: float = Field(default=0.5, gt=0)
    """A place counts as reached within this distance."""

    _has_extent = field_validator("area_m")(_with_extent)


class AdversarialParameters(AvoidingParameters):
    """Best response in the interception game."""

    pursuer_speed_assumed_m_s: float = Field(default=6.0, gt=0)
    """Top speed of the pursuers."""


class RecordedParameters(StrategyParameters):
    """A recorded flight, flown again."""

    file: Path
    """Track: text with the header timestamp,tx,ty,tz,qx,qy,qz,qw (s, m, z up)."""
    speed_scale: float = Field(default=1.0, gt=0, le=10)
    """Flown speed over recorded speed. Where that is beyond the vehicle's limit, the limit counts."""
    start_s: float = Field(default=0.0, ge=0)
    """Where in the recording the flight begins, from its first row."""
    rotation_deg: float = Field(default=0.0, ge=-360, le=360)
    """Clockwise, from the orientation in which the track's farthest point lies towards the nearest point of the boundary."""
    loop: bool = False
    """Begin again at the end, from there; otherwise stand."""
    position_gain_1_s: float = Field(default=1.5, gt=0)
    """Speed of correction per metre beside the track."""
    lead_max_m: float = Field(default=2.0, gt=0)
    """The track waits for a vehicle that is this far behind."""


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
