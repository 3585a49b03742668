"""The values that flow through one control period. Units are SI; planar arrays are (north, east) in the mission frame."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DISC_COLUMNS = ("north_m", "east_m", "radius_m", "v_north_m_s", "v_east_m_s", "down_top_m", "down_bottom_m")


@dataclass(frozen=True, slots=True)
class VehicleState:
    """Pose and velocity of one vehicle at `t_s` (fleet time), mission frame NED."""

    t_s: float
    position_ned_m: Array  # (3,)
    velocity_ned_m_s: Array  # (3,)
    yaw_rad: float  # clockwise from north, (-pi, pi]


@dataclass(frozen=True, slots=True)
class TeamMember:
    """The newest known state of a teammate.

    `state.t_s` is when `state` is true: the observation's time where it was moved there by its velocity already. `age_s` is how
    old, at the observation's time, the message is that told it.
    """

    name: str
    state: VehicleState
    mode: str
    eta_s: float | None
    age_s: float


@dataclass(frozen=True, slots=True)
class TargetTrack:
    """Estimate of the evader at `t_s`; covariance over (position, velocity) NED; `age_s` since the last measurement."""

    t_s: float
    position_ned_m: Array  # (3,)
    velocity_ned_m_s: Array  # (3,)
    covariance: Array  # (6, 6)
    age_s: float


@dataclass(frozen=True, slots=True)
class ObstacleSet:
    """Obstacle discs (not inflated) at `t_s` and the bearing intervals in which nothing was observed.

    discs: (n, 7) float64, columns DISC_COLUMNS; down_top_m / down_bottom_m are -inf / +inf where the height is unknown.
    unseen: (k, 2) float64, bearings [from, to) in rad clockwise from north, seen from the own position.
    """

    t_s: float
    discs: Array  # (n, 7)
    unseen: Array  # (k, 2)

    def with_standing(self, places: Array) -> ObstacleSet:
        """These, and after them discs (k, 3: north, east, radius) that stand, of unknown height; itself without any."""
        if not len(places):
            return self
        more = np.zeros((len(places), len(DISC_COLUMNS)))
        more[:, :3], more[:, 5], more[:, 6] = places, -np.inf, np.inf
        return ObstacleSet(self.t_s, np.vstack((self.discs, more)), self.unseen)


@dataclass(frozen=True, slots=True)
class Boundary:
    """The edge that the evader must not cross, as a polyline or (closed) polygon."""

    vertices_m: Array  # (k, 2) north, east
    closed: bool


@dataclass(frozen=True, slots=True)
class Limits:
    """What the vehicle can do and how much room it needs."""

    speed_max_m_s: float
    acceleration_max_m_s2: float
    jerk_max_m_s3: float
    yaw_rate_max_rad_s: float
    yaw_acceleration_max_rad_s2: float
    climb_rate_max_m_s: float
    body_radius_m: float
    safety_margin_m: float
    sink_rate_max_m_s: float = math.nan
    """As the climb rate where it is not given."""

    def __post_init__(self) -> None:
        if math.isnan(self.sink_rate_max_m_s):
            object.__setattr__(self, "sink_rate_max_m_s", self.climb_rate_max_m_s)


@dataclass(frozen=True, slots=True)
class Rendezvous:
    """Where the team is to meet the evader on its way, and the own slot about that place; mission frame, planar."""

    north_m: float
    east_m: float
    heading_rad: float
    """The evader's course on arrival, clockwise from north."""
    radius_m: float
    """Of the ring of slots."""
    slots: int
    """How many there are."""
    slot: int
    """The own one; below 0: behind the evader, as the so-manieth who trails it."""
    closing: bool
    """The ring is around the evader, and moves with it."""
    reachable: bool = True
    """Enough of the team can be there in time to close the ring."""


@dataclass(frozen=True, slots=True)
class Assignment:
    """The own part of the team's plan: from which side to close in on the evader, and when all are to be there."""

    bearing_rad: float
    """Seen from the evader, clockwise from north; with a rendezvous seen from there."""
    arrival_s: float
    """On the observation's clock."""
    rendezvous: Rendezvous | None = None
    """Of plans that meet the evader somewhere on its way."""


@dataclass(frozen=True, slots=True)
class Observation:
    """Everything a planner may know in one control period."""

    t_s: float
    dt_s: float
    own: VehicleState
    team: tuple[TeamMember, ...]
    target: TargetTrack | None
    obstacles: ObstacleSet
    boundary: Boundary
    assignment: Assignment | None = None


@dataclass(frozen=True, slots=True)
class Decision:
    """What a planner wants. `reason` is empty unless `mode` changed in this step; diagnostics are plain JSON values."""

    velocity_ned_m_s: Array  # (3,)
    acceleration_ned_m_s2: Array | None  # (3,)
    yaw_rad: float
    mode: str
    goal_ned_m: Array | None  # (3,)
    reason: str = ""
    diagnostics: Mapping[str, object] = field(default_factory=dict)
    flies_height: bool = False
    """The vertical velocity is all of it; False: it is added to what holds the mission's height."""


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What is sent to the autopilot: velocity in NED and yaw, optionally with acceleration feed-forward."""

    velocity_ned_m_s: Array  # (3,)
    yaw_rad: float
    acceleration_ned_m_s2: Array | None = None
    """Belongs to this velocity: whoever changes that drops it."""
