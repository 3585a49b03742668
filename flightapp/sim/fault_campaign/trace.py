"""What one flown mission left behind for the invariants: plain values, no simulation objects. Mission frame NED, SI units."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightapp.config.mission import Mission, Vehicle
from flightapp.core.types import Array, Limits

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class SentSetpoint:
    """One setpoint of the app, and the guards that changed it (None where the recording does not tell)."""

    t_s: float
    velocity_ned_m_s: tuple[float, float, float]
    yaw_rad: float
    guards: tuple[str, ...] | None


@dataclass(slots=True)
class Takeover:
    """A pilot takes a vehicle. `heard_s`: when the app could know; None where it never could."""

    t_s: float
    heard_s: float | None = None


@dataclass(frozen=True, slots=True)
class Wish:
    """An operator's command to one vehicle. `is_reachable`: its process lives and its network works."""

    t_s: float
    action: str
    is_reachable: bool
    answered_s: float | None
    accepted: bool


@dataclass(frozen=True, slots=True)
class InjectionReport:
    """What became of an injection; times are None where that never happened."""

    kind: str
    vehicle: str
    began_s: float | None
    felt_s: float | None
    excuses: bool
    """The app does not answer for where this vehicle flies once the fault is felt."""

    @property
    def outcome(self) -> str:
        return "felt" if self.felt_s is not None else "not felt" if self.began_s is not None else "not begun"


@dataclass(frozen=True, slots=True)
class RecordingCheck:
    """What reading a recording gave; `error` is empty where it could be read."""

    path: Path
    messages: int
    error: str


@dataclass(slots=True)
class VehicleTrace:
    """One vehicle. `states` (n, 7): t_s, true position (3), true velocity (3); `armed` (n,) and `on_ground` (n,) beside it."""

    vehicle: Vehicle
    limits: Limits
    states: Array
    armed: Flags
    on_ground: Flags
    setpoints: list[SentSetpoint] = field(default_factory=list)
    transmitted_s: list[float] = field(default_factory=list)
    """When a setpoint left, MAVSDK's repeats included."""
    commands: list[tuple[float, str]] = field(default_factory=list)
    takeovers: list[Takeover] = field(default_factory=list)
    wishes: list[Wish] = field(default_factory=list)
    outcome: str = ""
    error: str = ""
    is_piloted: bool = False
    """At the end."""
    crashes: list[str] = field(default_factory=list)
    """Exceptions that nobody handled, and tasks that did not end."""
    recordings: list[RecordingCheck] = field(default_factory=list)
    is_recorded: bool = True
    """False where the disk was full before anything had reached it."""

    @property
    def name(self) -> str:
        return self.vehicle.name


@dataclass(slots=True)
class Trace:
    """One mission."""

    seed: int
    mission: Mission
    vehicles: dict[str, VehicleTrace]
    injections: tuple[InjectionReport, ...]
    leftovers: list[str] = field(default_factory=list)
    """Threads and processes that outlived the mission."""


@dataclass(frozen=True, slots=True)
class Finding:
    """An invariant that does not hold. `vehicle` is empty where it concerns none of them."""

    vehicle: str
    time_s: float | None
    text: str
