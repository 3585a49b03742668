"""What a strategy is: a pure, seeded function of observations with a state of its own."""

from __future__ import annotations

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

__all__ = [
    "Boundary",
    "Decision",
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
