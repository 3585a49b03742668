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
class TargetSighting:
    """One measurement of the evader that reached this vehicle, from the evader itself or from a vehicle's camera."""

    t_s: float
    """When it reached the estimate."""
    measured_t_s: float
    source: str
    """telemetry, camera."""
    vehicle: str
    """Whose telemetry, whose camera."""
    north_m: float
    east_m: float
    sigma_m: float
    """Standard deviation, of a camera's along the line of sight."""
    used: bool
    """False: it did not fit, or nobody could tell whether it is of the evader."""
    innovation_m: float | None
    """From the predicted to the measured position; null without a prediction, like `nis`."""
    nis: float | None
    """Normalised innovation squared."""


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
    taken: int | None = None
    """Messages that came and were used."""


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
    """What was wrong with this frame."""
    age_s: list[float] = field(default_factory=list)
    """Of each disc: time since it was last seen."""
    confidence: list[float] = field(default_factory=list)
    """Of each disc, 0 to 1: how sure it is that something is there."""
    latency_s: float | None = None
    """From the capture of the frame to its discs."""
    frames_processed: int = 0
    frames_without_pose: int = 0
    """Frames that were not used because the own motion at their capture time was not known, in all."""
    frames_lost: int = 0
    """Frames that the camera took but that never arrived, in all."""
    camera_restarts: int = 0
    camera_temperature_c: float | None = None
    camera_fault: str = ""
    """What is wrong with the camera now; empty while frames come."""


@dataclass(slots=True)
class ObservedMember:
    """A teammate as planner and supervisor were given it: already moved to the observation's time."""

    name: str
    position_ned_m: list[float | None]
    velocity_ned_m_s: list[float | None]
    yaw_rad: float | None
    mode: str
    eta_s: float | None
    age_s: float | None
    takes_part: bool
    """False: only the supervisor was told."""


@dataclass(slots=True)
class ObservedTarget:
    """The track that planner and supervisor were given."""

    t_s: float
    position_ned_m: list[float | None]
    velocity_ned_m_s: list[float | None]
    covariance: list[float | None]
    """Row by row of (6, 6); of a symmetric one only the part from the diagonal on (21 numbers)."""
    age_s: float | None


@dataclass(slots=True)
class ObservationRecord:
    """Exactly what planner and supervisor were given in one control period, for `flightapp replay`.

    Obstacles stand in `/obstacles` under `frame_number`, the setpoint before in `/setpoint`, everything constant in the
    recording's attachments.
    """

    t_s: float
    dt_s: float
    planned: bool
    """The planner was asked."""
    held: bool
    """What it said was not flown."""
    own_position_ned_m: list[float | None]
    """Moved to `t_s`."""
    own_velocity_ned_m_s: list[float | None]
    own_yaw_rad: float | None
    own_age_s: float | None
    team: list[ObservedMember]
    target: ObservedTarget | None
    frame_number: int | None
    """Null before the first depth frame, and without a camera: then `obstacles_t_s` is `t_s`, and they are the mission's."""
    obstacles_t_s: float
    team_link_age_s: float | None
    battery_fraction: float | None
    assignment_bearing_rad: float | None = None
    assignment_arrival_s: float | None = None
    assignment_rendezvous: list[float] | None = None
    """Of plans that meet the evader on its way: north_m, east_m, heading_rad, radius_m, slots, slot, closing (0 or 1)
    and, where it is not older than that, reachable (0 or 1)."""
    told_discs: list[list[float]] | None = None
    """Obstacles that mates have told, which only the planner was given, after those of the frame: north_m, east_m, radius_m."""
    heights_trusted: bool | None = None
    """False: the supervisor was told that the own height must not be compared with an obstacle's; null: it might."""


@dataclass(slots=True)
class DecisionRecord:
    """What the planner decided."""

    t_s: float
    velocity_ned_m_s: list[float | None]
    """Null, here and below, where the planner gave a number that is none."""
    yaw_rad: float | None
    mode: str
    goal_ned_m: list[float | None] | None
    reason: str
    latency_s: float
    """Duration of Planner.step."""
    diagnostics: dict[str, object]


@dataclass(slots=True)
class Candidates:
    """What the dynamic window weighed, thinned out: arcs of constant speed and turn rate from the own position."""

    t_s: float
    north_m: float
    east_m: float
    down_m: float
    course_rad: float
    """Of the own velocity, where every arc begins."""
    horizon_s: float
    """Duration of the drawn arcs."""
    speed_m_s: list[float]
    turn_rad_s: list[float]
    score: list[float]
    """Weighted sum of the critics; 0 where the candidate is rejected."""
    verdict: list[int]
    """0 admissible, 1 collides on its arc, 2 collides while braking."""
    best: int | None
    """Row of the chosen candidate; null where none is admissible."""


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
    wish_ned_m_s: list[float | None] | None = None
    """What the supervisor was asked for: the planner's velocity with the height loop, or the hover's."""
    wish_yaw_rad: float | None = None
    acceleration_ned_m_s2: list[float] | None = None
    """Fed forward."""


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
    """Mission phase (preflight, arm, takeoff, ingress, ready, pursue, return, land, done) and outcome once known."""

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
    setpoint_gap_p50_ms: float | None = None
    """Time between setpoints that follow each other, since the previous sample; null where none followed another."""
    setpoint_gap_p99_ms: float | None = None
    setpoint_gap_max_ms: float | None = None
    recording_dropped_by_channel: dict[str, int] = field(default_factory=dict)
    recording_flush_slowest_s: float = 0.0
    """Longest time that handing the recording to the disk has taken so far."""


@dataclass(slots=True)
class ClockOffset:
    """What another machine's clock is ahead of this one's, as measured by round trips; half the quickest is the uncertainty."""

    vehicle: str
    ahead_s: float
    uncertainty_s: float


@dataclass(slots=True)
class ClockOffsets:
    """All that are known at `t_s`; stamps of those vehicles have been corrected by them."""

    t_s: float
    offsets: list[ClockOffset]


@dataclass(slots=True)
class PlanSeat:
    """One pursuer's part of the plan; `alone_t_s`: when it would be there at full speed."""

    vehicle: str
    bearing_rad: float
    """Of its sector, from the evader, clockwise from north."""
    north_m: float
    east_m: float
    alone_t_s: float


@dataclass(slots=True)
class TeamPlan:
    """The leader's plan that is in force at this vehicle from `t_s` on; the newer (term, version) replaces the older."""

    t_s: float
    leader: str
    term: int
    version: int
    arrival_t_s: float
    seats: list[PlanSeat]


@dataclass(slots=True)
class Way:
    """A way past known obstacles that the vehicle begins to fly: ingress, way out of a trap, or way home."""

    t_s: float
    purpose: str
    duration_s: float
    """As planned."""
    gap_m: float
    """Kept from everything that was known and seen."""
    places_ned_m: list[list[float]]
    """(n, 3) along it, at equal times."""


@dataclass(slots=True)
class CameraMounting:
    """Pose of the camera in the body frame (forward, right, down); zero angles look straight ahead."""

    forward_m: float
    right_m: float
    down_m: float
    roll_deg: float
    pitch_deg: float
    yaw_deg: float


@dataclass(slots=True)
class DepthInfo:
    """What belongs to the depth image that has the same time on `/depth`: all that it takes to perceive it again."""

    version: int
    """Of this message: raised when an older reader would misread it."""
    t_s: float
    """Capture time."""
    frame_number: int
    depth_unit_m: float
    """What one step of the 16-bit image is worth; 0 in the image: no return."""
    stride: int
    """Every how manieth row and column of the camera's image was kept. Size and intrinsics are those of the kept image."""
    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    position_ned_m: list[float] | None
    """Of the vehicle at `t_s`; null, like velocity and angles, as long as the autopilot has not told it."""
    velocity_ned_m_s: list[float] | None
    roll_rad: float | None
    pitch_rad: float | None
    yaw_rad: float | None
    mounting: CameraMounting
    range_min_m: float
    range_max_m: float
    """Depths outside are not believed."""
    ground_down_m: float
    """Height of the ground in the mission frame."""
    dropped: int
    """Frames that were due but replaced by a newer one before they were compressed, in all."""


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
