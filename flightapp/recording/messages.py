"""What is recorded, one type a channel. Units stand in the names; positions and velocities are NED in the mission frame.

Times `*_t_s` and `t_s` are fleet time (see `core.clock`). These types are the schema: JSON schemas in the recording are
derived from them. Sequences are plain lists so that a recording can be read without this package.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class OwnState:
    """Own state as the control loop used it; `age_s` since it was true."""

    t_s: float
    position_ned_m: list[float]
    velocity_ned_m_s: list[float]
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    age_s: float


@dataclass(slots=True)
class AutopilotStatus:
    """Autopilot mode as reported with its heartbeats."""

    t_s: float
    connected: bool
    flight_mode: str
    armed: bool
    landed_state: str
    heartbeat_age_s: float


@dataclass(slots=True)
class Battery:
    """Battery as reported by the autopilot."""

    t_s: float
    voltage_v: float | None
    remaining_fraction: float | None


@dataclass(slots=True)
class Target:
    """The evader as this vehicle believes it to be."""

    t_s: float
    position_ned_m: list[float]
    velocity_ned_m_s: list[float]
    position_sigma_m: float
    age_s: float


@dataclass(slots=True)
class Teammate:
    """Newest known state of one other vehicle of the fleet."""

    name: str
    role: str
    position_ned_m: list[float]
    velocity_ned_m_s: list[float]
    mode: str
    phase: str
    eta_s: float | None
    age_s: float
    lost: int
    """Messages that never came, counted from gaps in the sequence numbers."""


@dataclass(slots=True)
class Team:
    """All other vehicles of the fleet that were ever heard."""

    t_s: float
    members: list[Teammate]


@dataclass(slots=True)
class Obstacles:
    """Discs and unseen sectors after one depth frame."""

    t_s: float
    """Time at which they reached the control loop."""
    frame_t_s: float
    """Capture time of the frame."""
    frame_number: int
    discs: list[list[float | None]]
    """Rows: north_m, east_m, radius_m, v_north_m_s, v_east_m_s, down_top_m, down_bottom_m (null: unknown)."""
    unseen_rad: list[list[float]]
    perception_latency_s: float
    """Processing time of this frame."""
    frames_skipped: int
    """Frames that newer ones replaced before they were used, in all."""
    events: list[str]


@dataclass(slots=True)
class DecisionRecord:
    """What the planner decided."""

    t_s: float
    velocity_ned_m_s: list[float]
    yaw_rad: float
    mode: str
    goal_ned_m: list[float] | None
    reason: str
    latency_s: float
    """Duration of Planner.step."""
    diagnostics: dict[str, object]


@dataclass(slots=True)
class SetpointRecord:
    """What was sent to the autopilot, and which guards changed the planner's wish."""

    t_s: float
    velocity_ned_m_s: list[float]
    yaw_rad: float
    frame_t_s: float | None
    """Capture time of the newest depth frame that it rests on; None without a camera or before the first frame."""
    new_frame: bool
    """True on the first setpoint after that frame: its t_s - frame_t_s is the latency from light to action."""
    acting: list[list[str]]
    """(guard, reason) in order."""
    clearance_m: float | None
    """Clearance to the known discs; None without any."""


@dataclass(slots=True)
class Event:
    """Something a person should know."""

    t_s: float
    level: str
    """info, warning, error."""
    name: str
    text: str
    data: dict[str, object] = field(default_factory=dict)


@dataclass(slots=True)
class Phase:
    """Mission phase (preflight, arm, takeoff, ready, pursue, return, land, done) and outcome once known."""

    t_s: float
    phase: str
    reason: str
    outcome: str | None


@dataclass(slots=True)
class Health:
    """The process itself."""

    t_s: float
    cpu_fraction: float
    """Share of one core since the previous sample."""
    memory_mb: float
    loop_lateness_max_ms: float
    """Worst lateness of the control loop since the previous sample."""
    recording_dropped: int
    setpoints_sent: int


@dataclass(slots=True)
class TruthRecord:
    """True state of one simulated vehicle (simulation only)."""

    t_s: float
    vehicle: str
    position_ned_m: list[float]
    velocity_ned_m_s: list[float]
    yaw_rad: float
    armed: bool
    on_ground: bool
