"""What happens in one mission of the campaign: the mission itself, and the faults with their moments."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from flightapp.config.mission import Mission


class Moment(StrEnum):
    """What a fault waits for; its delay counts from then on."""

    START = "start"
    """The beginning of the simulation: before preflight."""
    TAKEOFF = "takeoff"
    """The vehicle climbs."""
    PURSUIT = "pursuit"
    """The vehicle pursues."""
    TERMINAL = "terminal"
    """A pursuer is near the evader."""
    OBSTACLE = "obstacle"
    """The vehicle flies close to an obstacle."""
    WAY_HOME = "way home"
    """The vehicle returns or lands."""


@dataclass(frozen=True, slots=True)
class Injection:
    """One fault to inject. `duration_s` None: to the end. `fields`: what its kind takes, sorted by name."""

    kind: str
    vehicle: str
    moment: Moment
    delay_s: float
    duration_s: float | None
    fields: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Plan:
    """Everything that a seed decides."""

    seed: int
    mission: Mission
    injections: tuple[Injection, ...]
