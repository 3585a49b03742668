"""What a strategy is: a pure, seeded function of observations with a state of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from flightapp.core.types import (
    Boundary,
    Decision,
    Limits,
    Observation,
    ObstacleSet,
    TargetTrack,
    TeamMember,
    VehicleState,
)
from flightapp.fleet.coordination.team_plan import TeamPlan

__all__ = [
    "BLOCKED",
    "NEEDS_HELP",
    "STATE_LOST",
    "STUCK",
    "Boundary",
    "Build",
    "BuildTeamPlan",
    "Decision",
    "Given",
    "Limits",
    "Observation",
    "ObstacleSet",
    "Planner",
    "TargetTrack",
    "TeamMember",
    "VehicleState",
]


class Planner(Protocol):
    """Synchronous, reads no clock, no network and no global random state; the same observations give the same decisions."""

    def step(self, observation: Observation) -> Decision: ...

    def reset(self, seed: int | None = None) -> None: ...


Given = Mapping[str, object] | None

STUCK, BLOCKED, STATE_LOST = "stuck", "blocked", "state_lost"
NEEDS_HELP = frozenset({STUCK, BLOCKED, STATE_LOST})
"""Modes in which a strategy says that it cannot go on by itself: trapped; its goal lies inside an obstacle; no own state. The
vehicle is kept from harm as in any other mode, and the operator is warned.
"""


class Build(Protocol):
    """The function `build` of a strategy's module: `name` is the one in the registry, under which several may share a module."""

    def __call__(self, name: str, limits: Limits, given: Given, seed: int) -> Planner: ...


class BuildTeamPlan(Protocol):
    """The function `build_team_plan` of a module in the registry's TEAM_PLANS; `given` is what the strategy itself is given."""

    def __call__(self, name: str, limits: Limits, given: Given) -> TeamPlan: ...
