"""What the leader tells everybody: who comes from which side of the evader, and when all are to be there."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.core.types import Assignment, Rendezvous


@dataclass(frozen=True, slots=True)
class Seat:
    """One pursuer's part. Mission frame, planar; fleet time."""

    vehicle: str
    bearing_rad: float
    """Of its sector, seen from the evader, clockwise from north, (-pi, pi]."""
    north_m: float
    """Where its sector's middle is expected to be when it gets there."""
    east_m: float
    alone_s: float
    """When it would be there at full speed."""
    slot: int = 0
    """Of a meeting, the vehicle's place on the ring; below 0 it trails the evader, -1 first."""


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where the evader is met, in plans that foresee that."""

    north_m: float
    east_m: float
    heading_rad: float
    """The evader's course on arrival."""
    radius_m: float
    """Of the ring of slots."""
    t_s: float
    """Fleet time."""
    slots: int
    closing: bool
    """The ring is around the evader, and moves with it."""
    reachable: bool = True
    """Enough of the team can be there in time to close the ring."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The newer (term, version) replaces the older: a term has one leader, who counts its plans."""

    term: int
    version: int
    seats: tuple[Seat, ...]
    meeting: Meeting | None = None

    @property
    def rank(self) -> tuple[int, int]:
        return self.term, self.version

    @property
    def members(self) -> tuple[str, ...]:
        """Who takes part, in the order of the seats."""
        return tuple(seat.vehicle for seat in self.seats)

    @property
    def arrival_s(self) -> float:
        """When all are to be there: the meeting, or else the latest sets the time."""
        return max(seat.alone_s for seat in self.seats) if self.meeting is None else self.meeting.t_s

    def seat_of(self, vehicle: str) -> Seat | None:
        """None for who takes no part."""
        return next((seat for seat in self.seats if seat.vehicle == vehicle), None)


def assignment_of(plan: Plan, vehicle: str) -> Assignment | None:
    """The part of `vehicle`, as its planner gets it; None for who takes no part."""
    seat, at = plan.seat_of(vehicle), plan.meeting
    if seat is None:
        return None
    if at is None:
        return Assignment(seat.bearing_rad, plan.arrival_s)
    there = Rendezvous(at.north_m, at.east_m, at.heading_rad, at.radius_m, at.slots, seat.slot, at.closing, at.reachable)
    return Assignment(seat.bearing_rad, plan.arrival_s, there)
