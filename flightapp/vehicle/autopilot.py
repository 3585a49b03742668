"""What the app needs of an autopilot, and nothing more."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flightapp.core.types import Setpoint, VehicleState


@dataclass(frozen=True, slots=True)
class Motion:
    """Own state in the mission frame with attitude (rad, body FRD), and when it arrived here (fleet time)."""

    state: VehicleState
    roll_rad: float
    pitch_rad: float
    arrived_s: float


@dataclass(frozen=True, slots=True)
class Status:
    """Newest heartbeat content: flight mode by its PX4 name, arming and landed state; `heartbeat_s` is its arrival."""

    connected: bool
    flight_mode: str
    armed: bool
    landed_state: str
    heartbeat_s: float


@dataclass(frozen=True, slots=True)
class BatteryState:
    """Battery; None where the autopilot does not say."""

    voltage_v: float | None
    remaining_fraction: float | None


@dataclass(frozen=True, slots=True)
class HealthState:
    """The autopilot's own pre-arm view, and whether its local origin is known here."""

    global_position_ok: bool
    home_ok: bool
    armable: bool
    origin_known: bool

    def missing(self) -> tuple[str, ...]:
        """What is not ready yet, in words; empty when all is."""
        named = (
            ("global position", self.global_position_ok),
            ("home position", self.home_ok),
            ("ready to arm", self.armable),
            ("local origin", self.origin_known),
        )
        return tuple(name for name, ok in named if not ok)


@dataclass(frozen=True, slots=True)
class Accuracy:
    """The GNSS receiver's own view; `fix` as MAVLink's GPS_FIX_TYPE (3: 3-D), standard deviations NaN where it does not tell."""

    satellites: int
    fix: int
    horizontal_m: float
    vertical_m: float


@dataclass(frozen=True, slots=True)
class AutopilotDetails:
    """What is worth knowing before a flight and not needed in it."""

    autopilot: str
    """PX4, or what it is instead; empty while unknown."""
    version: tuple[int, int, int] | None
    hardware_uid: str
    system_ids_heard: tuple[int, ...]
    twin: str
    """How a second autopilot with the same system id shows; empty while there is no sign of one."""
    state_rate_hz: float
    attitude_rate_hz: float
    accuracy: Accuracy | None
    home_ned_m: tuple[float, float, float] | None
    transmitter_seen: bool | None
    """Whether the pilot's transmitter is received; None where it is not reported."""
    telemetry_gap_s: float | None = None
    """Longest wait for position or attitude lately; None where it is not measured."""


class Autopilot(Protocol):
    """One vehicle's autopilot. Commands raise FlightError with the autopilot's own reason when they are refused."""

    async def connect(self) -> str:
        """Connect, start telemetry; a line that says what was found."""
        ...

    def motion(self) -> Motion | None: ...

    def status(self) -> Status: ...

    def battery(self) -> BatteryState | None: ...

    def health(self) -> HealthState: ...

    def accuracy(self) -> Accuracy | None:
        """The GNSS receiver's own view, None until it was heard; cheap enough for every control period."""
        ...

    def details(self) -> AutopilotDetails: ...

    async def set_heights(self, takeoff_m: float, return_m: float) -> None:
        """Heights above the take-off point for take-off and return; the return height holds near home too."""
        ...

    async def parameter(self, name: str, *, is_integer: bool) -> float | None:
        """Value of a parameter; None where this autopilot has no such parameter."""
        ...

    async def set_parameter(self, name: str, value: float, *, is_integer: bool) -> None: ...

    async def arm(self) -> None: ...

    async def disarm(self) -> None: ...

    async def takeoff(self) -> None: ...

    async def start_offboard(self) -> None:
        """Ask for OFFBOARD; setpoints must be flowing already."""
        ...

    def send(self, setpoint: Setpoint) -> None:
        """Send one setpoint now; never blocks. ValueError for values that are not finite."""
        ...

    async def return_to_launch(self) -> None: ...

    async def land(self) -> None: ...

    async def terminate(self) -> None:
        """End the flight at once: motors off, parachute where there is one."""
        ...

    def take_status_texts(self) -> list[tuple[float, str, str]]:
        """(arrival, severity, text) since the last call, with what was noticed about the link itself among them."""
        ...

    def close(self) -> None: ...


FIX_3D = 3
"""Without it PX4 dead-reckons for seconds before its estimator calls the position bad; by then it has left OFFBOARD."""


def vouches_for_position(autopilot: Autopilot) -> bool:
    """Whether `autopilot` says that it knows where it is, and its receiver has a fix in three dimensions, where it tells."""
    accuracy = autopilot.accuracy()
    return autopilot.health().global_position_ok and (accuracy is None or accuracy.fix >= FIX_3D)
