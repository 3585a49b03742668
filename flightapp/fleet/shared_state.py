"""What is known of one other vehicle: its newest state and intent as one."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.fleet.messages.codec import Header
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State


@dataclass(frozen=True, slots=True)
class SharedState:
    """One vehicle as it describes itself: mission frame NED, fleet time of the receiver, SI units."""

    vehicle: str
    role: str
    sequence: int
    sent_s: float
    t_s: float
    position_ned_m: tuple[float, float, float]
    velocity_ned_m_s: tuple[float, float, float]
    yaw_rad: float
    airborne: bool
    phase: str
    mode: str
    outcome: str | None
    eta_s: float | None
    target_distance_m: float | None
    clearance_m: float | None
    link_age_s: float | None
    mission: str
    guards: tuple[str, ...]
    system_id: int
    goal_ned_m: tuple[float, float, float] | None
    battery_fraction: float | None = None
    due_s: float = 0.0
    """When the next state is due at the latest, from `sent_s`; 0: not told."""


def join(header: Header, state: State, intent: Intent) -> SharedState:
    """`header`: of the state."""
    return SharedState(
        vehicle=header.sender,
        role=intent.role,
        sequence=header.sequence,
        sent_s=header.sent_s,
        t_s=state.t_s,
        position_ned_m=state.position_ned_m,
        velocity_ned_m_s=state.velocity_ned_m_s,
        yaw_rad=state.yaw_rad,
        airborne=state.airborne,
        phase=state.phase,
        mode=intent.mode,
        outcome=state.outcome,
        eta_s=None if intent.arrival_s is None else max(0.0, intent.arrival_s - state.t_s),
        target_distance_m=intent.target_distance_m,
        clearance_m=intent.clearance_m,
        link_age_s=intent.link_age_s,
        mission=intent.mission,
        guards=intent.guards,
        system_id=intent.system_id,
        goal_ned_m=intent.goal_ned_m,
        battery_fraction=intent.battery_fraction,
        due_s=state.due_s,
    )
