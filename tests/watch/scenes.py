"""Fleets as they might be heard, for the tests of what is made of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flightapp.config.mission import load_mission
from flightapp.fleet.clock_offset import Offset
from flightapp.fleet.shared_state import SharedState
from flightapp.watch.data_model_heard import Heard

MISSION_FILE = Path(__file__).parents[2] / "missions/demo_two_pursuers.toml"
MISSION = load_mission(MISSION_FILE)
DIGEST = "0123456789ab"
ROLES = {vehicle.name: vehicle.role for vehicle in MISSION.vehicles}
NOW_S = 1000.0


def state(vehicle: str = "p1", sent_s: float = NOW_S - 0.05, **changes: Any) -> SharedState:
    """In the middle of a pursuit, nothing wrong."""
    values: dict[str, Any] = {
        "vehicle": vehicle,
        "role": ROLES[vehicle],
        "sequence": 7,
        "sent_s": sent_s,
        "t_s": sent_s,
        "position_ned_m": (20.0, 5.0, -5.0),
        "velocity_ned_m_s": (3.0, 4.0, 0.0),
        "yaw_rad": 0.0,
        "airborne": True,
        "phase": "pursue",
        "mode": "coarse",
        "outcome": None,
        "eta_s": None,
        "target_distance_m": 12.0,
        "clearance_m": 3.0,
        "link_age_s": 0.05,
        "mission": DIGEST,
        "guards": (),
        "system_id": 1,
        "goal_ned_m": None,
    }
    return SharedState(**(values | changes))


def heard(*states: SharedState, now_s: float = NOW_S, **rest: Any) -> Heard:
    """`states` and well-measured clocks."""
    offsets = {one.vehicle: Offset(0.001, 0.001) for one in states}
    return Heard(now_s, {one.vehicle: one for one in states}, **({"offsets": offsets} | rest))


def everybody(sent_s: float = NOW_S - 0.05, **changes: Any) -> tuple[SharedState, ...]:
    return tuple(state(name, sent_s, **changes) for name in ROLES)
