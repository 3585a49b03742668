"""What was heard of the fleet by one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flightapp.fleet.clock_offset import Offset
from flightapp.fleet.election.beacon import Beacon
from flightapp.fleet.messages.sighting import Sighting
from flightapp.fleet.shared_state import SharedState


@dataclass(frozen=True, slots=True)
class Heard:
    """By vehicle name, the newest of each; stamps are on the clock of whoever listens, as far as offsets are known."""

    now_s: float
    states: Mapping[str, SharedState]
    offsets: Mapping[str, Offset] = field(default_factory=dict)
    beacons: Mapping[str, tuple[float, Beacon]] = field(default_factory=dict)
    """With the time at which each was sent."""
    sightings: Mapping[str, Sighting] = field(default_factory=dict)
    complaints: tuple[str, ...] = ()
    """Sentences about messages that could not be read, since the last look."""
