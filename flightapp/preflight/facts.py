"""What preflight knows of the vehicle at one moment. Plain values: checks judge them without touching anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.fleet.security.credentials import Credentials
from flightapp.vehicle.autopilot import AutopilotDetails, BatteryState, HealthState, Motion, Status

Parameters = Mapping[str, float | None]
"""PX4 parameters that were asked for; None where this version of the autopilot does not have one."""


@dataclass(frozen=True, slots=True)
class CameraFacts:
    """The depth camera as the perception thread sees it; ages and latencies in s."""

    frame_age_s: float | None
    latency_s: float | None
    rate_hz: float
    failure: str
    fault: str
    restarts: int
    warning: str = ""
    """What should be put right although frames come: a camera on USB 2."""


@dataclass(frozen=True, slots=True)
class TeammateFacts:
    """Another vehicle of the mission, as last heard; None where it was never."""

    name: str
    age_s: float | None
    mission_digest: str
    system_id: int | None
    clock_ahead_s: float
    """How far the stamps of its quickest message were ahead of this machine's time; link latency makes it smaller."""
    clock_measured_s: float | None = None
    """How far its clock is ahead, by round trips; then stamps are corrected by it. None while it does not answer."""


@dataclass(frozen=True, slots=True)
class ComputerFacts:
    """The companion computer."""

    free_bytes: int
    governors: tuple[str, ...]
    """Distinct CPU frequency governors; empty where the machine does not tell."""
    clock_synchronised: bool | None
    """Whether the kernel's clock is disciplined by NTP or PTP; None where that is not known."""


@dataclass(frozen=True, slots=True)
class RecorderFacts:
    """The flight recorder, which runs since the vehicle's process began."""

    flush_slowest_s: float
    """Longest time that handing the recording to the disk has taken."""
    error: str | None = None


@dataclass(frozen=True, slots=True)
class WayFacts:
    """A way that was planned on the ground; `text` says how long it is, or why there is none."""

    is_found: bool
    text: str


@dataclass(frozen=True, slots=True)
class Facts:
    """Everything, at `t_s`."""

    t_s: float
    waited_s: float
    mission: Mission
    mission_digest: str
    profile: Profile
    vehicle: Vehicle
    status: Status
    health: HealthState
    motion: Motion | None
    motion_age_s: float | None
    battery: BatteryState | None
    details: AutopilotDetails
    parameters: Parameters
    camera: CameraFacts | None
    teammates: tuple[TeammateFacts, ...]
    computer: ComputerFacts
    credentials: Credentials | None = None
    """With which it joins the fleet; None: the fleet is open."""
    recorder: RecorderFacts | None = None
    ways: tuple[WayFacts, ...] = ()
    """To the station and home from there, where the mission plans them."""
