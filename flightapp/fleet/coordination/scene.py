"""What the leader plans from: the evader, the pursuers that take part, and what stands in their ways."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.core.types import Array


@dataclass(frozen=True, slots=True)
class Pursuer:
    """One that is airborne, heard, and pursues. Mission frame."""

    name: str
    north_m: float
    east_m: float
    speed_max_m_s: float


@dataclass(frozen=True, slots=True)
class Scene:
    """At one moment, mission frame; `discs` (m, >=3) north, east, radius without any margin, as the leader knows them."""

    north_m: float
    east_m: float
    v_north_m_s: float
    v_east_m_s: float
    pursuers: tuple[Pursuer, ...]
    discs: Array
