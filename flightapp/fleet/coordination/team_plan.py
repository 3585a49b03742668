"""What the leader plans by: a strategy may bring its own, else the circle around the evader is divided (`sector_plan`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flightapp.fleet.coordination.plan import Meeting, Plan, Seat
from flightapp.fleet.coordination.scene import Scene


@dataclass(frozen=True, slots=True)
class Draft:
    """A plan before it has a number."""

    seats: tuple[Seat, ...]
    meeting: Meeting | None = None


class TeamPlan(Protocol):
    """One vehicle's: it listens always, and drafts while that vehicle leads. Deterministic, without a clock."""

    @property
    def period_s(self) -> float:
        """Between two plans."""
        ...

    @property
    def leaderless_s(self) -> float:
        """After so long without a leader a plan counts no more: everybody then plans alone; inf: it stays in force."""
        ...

    def note(self, now_s: float, scene: Scene) -> None:
        """What is known now; also on vehicles that do not lead, which may have to go on from here."""
        ...

    def draft(self, now_s: float, scene: Scene, before: Plan | None) -> Draft:
        """Seats for all pursuers of `scene` (at least one). before: the plan in force, perhaps another leader's."""
        ...
