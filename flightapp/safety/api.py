"""What a guard is: it sees a setpoint and the situation, and returns that setpoint or a safer one with its reason."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flightapp.core.types import Limits, ObstacleSet, Setpoint, TargetTrack, TeamMember, VehicleState


@dataclass(frozen=True, slots=True)
class SafetyContext:
    """The situation a setpoint is judged in. Ages are seconds at `t_s`; infinite where nothing ever arrived."""

    t_s: float
    dt_s: float
    name: str
    own: VehicleState
    own_age_s: float
    team: tuple[TeamMember, ...]
    target: TargetTrack | None
    obstacles: ObstacleSet
    obstacles_age_s: float
    previous: Setpoint | None
    limits: Limits


@dataclass(frozen=True, slots=True)
class GuardVerdict:
    """`reason` is empty when the guard let the setpoint pass unchanged."""

    setpoint: Setpoint
    reason: str = ""


class Guard(Protocol):
    """One safety rule."""

    @property
    def name(self) -> str: ...

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict: ...


@dataclass(frozen=True, slots=True)
class Supervised:
    """The supervisor's last word: the setpoint to send and who changed it, in order (guard name, reason)."""

    setpoint: Setpoint
    acting: tuple[tuple[str, str], ...]
