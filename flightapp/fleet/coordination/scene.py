"""What the leader plans from: the evader, the pursuers that take part, and what stands in their ways."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.core.types import Array, VehicleState


@dataclass(frozen=True, slots=True)
class Pursuer:
    """One that is airborne, heard, and pursues. Mission frame."""

    name: str
    north_m: float
    east_m: float
    speed_max_m_s: float
    speed_m_s: float = 0.0
    heading_rad: float = 0.0
    """Of the nose, clockwise from north."""


@dataclass(frozen=True, slots=True)
class Scene:
    """At one moment, mission frame; `discs` (m, >=3) north, east, radius without any margin, as the leader knows them."""

    north_m: float
    east_m: float
    v_north_m_s: float
    v_east_m_s: float
    pursuers: tuple[Pursuer, ...]
    discs: Array


def pursuer_of(name: str, state: VehicleState, speed_max_m_s: float) -> Pursuer:
    """The vehicle `name` in `state`."""
    north, east, _ = state.position_ned_m.tolist()
    v_north, v_east, _ = state.velocity_ned_m_s.tolist()
    return Pursuer(name, north, east, speed_max_m_s, math.hypot(v_north, v_east), state.yaw_rad)
