"""What a guard is: it sees a setpoint and the situation, and returns that setpoint or a safer one with its reason.

What no setpoint can cure a guard asks the executive for: a `Demand`. Guards never switch modes themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

from flightapp.core.types import Limits, ObstacleSet, Setpoint, TargetTrack, TeamMember, VehicleState


class Action(IntEnum):
    """What a guard may ask for, the stricter the greater."""

    HOLD = 1
    """The planner no longer decides; setpoints go on through the supervisor, so that its guards can still push back."""
    RETURN = 2
    """Go home and land there."""
    LAND = 3
    """Land here."""
    TERMINATE = 4
    """End the flight at once, whatever becomes of the vehicle."""


@dataclass(frozen=True, slots=True)
class Demand:
    """What a guard asks of the executive, and why. It stands until the guard no longer repeats it."""

    action: Action
    guard: str
    reason: str


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
    team_link_age_s: float | None = None
    """Since anything was heard of any other vehicle of the fleet; None where nobody is expected to be heard."""
    battery_fraction: float | None = None
    """What is left, 0 to 1; None where the autopilot does not say."""
    heights_trusted: bool = True
    """Whether the own height may be compared with an obstacle's: not while the autopilot does not vouch for the position."""


@dataclass(frozen=True, slots=True)
class GuardVerdict:
    """`reason` is empty when the guard let the setpoint pass unchanged."""

    setpoint: Setpoint
    reason: str = ""
    final: bool = False
    """True: there is no own state by which any other guard could judge, so this setpoint is sent as it is."""


class Guard(Protocol):
    """One safety rule about setpoints."""

    @property
    def name(self) -> str: ...

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict: ...


class Watch(Protocol):
    """One safety rule about the situation; called once a control period."""

    @property
    def name(self) -> str: ...

    def demand(self, context: SafetyContext) -> Demand | None: ...


@dataclass(frozen=True, slots=True)
class Supervised:
    """The supervisor's last word: the setpoint to send, who changed it in order (guard name, reason), and the strictest
    demand of this period, which the executive is to carry out. A demand never makes the setpoint unsafe to send meanwhile.
    """

    setpoint: Setpoint
    acting: tuple[tuple[str, str], ...]
    demand: Demand | None = None
