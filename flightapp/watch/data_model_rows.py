"""One row for each vehicle of the mission, whether it was heard or not."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from flightapp.config.mission import Mission
from flightapp.fleet.clock_offset import Offset
from flightapp.fleet.shared_state import SharedState
from flightapp.watch.data_model_heard import Heard
from flightapp.watch.data_model_thresholds import Thresholds

SHAPING = ("acceleration", "speed", "yaw-rate")
"""Guards that hold setpoints to what the vehicle can do: every sharp turn meets them, which is neither event nor alarm."""


class Link(Enum):
    """How well a vehicle is heard; the words are what a person reads."""

    FRESH = "fresh"
    LATE = "late"
    LOST = "LOST"
    NEVER = "not heard"
    OVER = "over"
    """Its mission is over and its process may have ended: silence is no alarm."""


@dataclass(frozen=True, slots=True)
class Row:
    """One vehicle. `age_s`: since its newest message was sent; None: never heard."""

    name: str
    role: str
    link: Link
    age_s: float | None
    state: SharedState | None
    offset: Offset | None
    leads: bool
    guards: tuple[tuple[str, float], ...]
    """Those that act, with how long they have, s."""

    @property
    def height_m(self) -> float | None:
        """Above the mission's datum."""
        return None if self.state is None else -self.state.position_ned_m[2]

    @property
    def speed_m_s(self) -> float | None:
        """Over ground."""
        return None if self.state is None else math.hypot(*self.state.velocity_ned_m_s[:2])


def rows_of(
    mission: Mission, heard: Heard, thresholds: Thresholds, leader: str | None, guards: dict[str, tuple[tuple[str, float], ...]]
) -> tuple[Row, ...]:
    """In the order of the mission. Roles are the mission's: what a message says of its sender's role is not believed."""
    rows = []
    for vehicle in mission.vehicles:
        name, state = vehicle.name, heard.states.get(vehicle.name)
        age_s = None if state is None else max(0.0, heard.now_s - state.sent_s)
        link = link_of(state, age_s, thresholds)
        rows.append(Row(name, vehicle.role, link, age_s, state, heard.offsets.get(name), name == leader, guards.get(name, ())))
    return tuple(rows)


def link_of(state: SharedState | None, age_s: float | None, thresholds: Thresholds) -> Link:
    """The verdict on an age."""
    if state is None or age_s is None:
        return Link.NEVER
    if age_s <= thresholds.late_age_of_s(state):
        return Link.FRESH
    if state.phase == "done":
        return Link.OVER
    return Link.LATE if age_s <= thresholds.lost_age_of_s(state) else Link.LOST
