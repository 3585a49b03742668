"""What the leader tells everybody: who comes from which side of the evader, and when all are to be there."""

from __future__ import annotations

from dataclasses import dataclass


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


@dataclass(frozen=True, slots=True)
class Plan:
    """The newer (term, version) replaces the older: a term has one leader, who counts its plans."""

    term: int
    version: int
    seats: tuple[Seat, ...]

    @property
    def rank(self) -> tuple[int, int]:
        return self.term, self.version

    @property
    def members(self) -> tuple[str, ...]:
        """Who takes part, in the order of the seats."""
        return tuple(seat.vehicle for seat in self.seats)

    @property
    def arrival_s(self) -> float:
        """When all are to be there: the latest sets the time."""
        return max(seat.alone_s for seat in self.seats)

    def seat_of(self, vehicle: str) -> Seat | None:
        """None for who takes no part."""
        return next((seat for seat in self.seats if seat.vehicle == vehicle), None)
