"""What one pursuer makes of an observation: planes of all that it must not touch, places of the team, the evader."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.angles import TWO_PI
from flightapp.core.types import Array, Limits, Observation, TargetTrack, TeamMember
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.planning.geometry.half_planes import PLANE_COLUMNS, ROUND_COLUMNS, add_polygons, add_rounds
from flightapp.planning.geometry.polygons import polygons
from flightapp.planning.plane import Point, planar

Mask = NDArray[np.bool_]

DISC_SHARE, MATE_SHARE = 1.0, 0.5
"""Of the room before it that is one's own."""
EDGES = 4
MOVING_M_S = 0.1
"""A disc that is faster is a moving obstacle, and told as one."""
FORGOTTEN_S = 10.0
"""A teammate's last place is kept clear of no longer than this."""


@dataclass(frozen=True, slots=True)
class Evader:
    """Where the evader is believed to be."""

    place: Point
    velocity: Point
    age_s: float


@dataclass(frozen=True, slots=True)
class Mate:
    """What one teammate said last, moved to the present."""

    place: Point
    velocity: Point
    age_s: float
    name: str
    mode: str


@dataclass(frozen=True, slots=True)
class Situation:
    """One control period, before anything is decided. Lengths in m, mission frame, (north, east)."""

    t_s: float
    period_s: float
    own: Point
    """Where the vehicle's lag puts it: from there everything is judged."""
    velocity: Point
    yaw_rad: float
    evader: Evader | None
    team: Array
    """(k, 2): where the vehicles are now, this one first, then every teammate that still counts."""
    lag_s: float
    rounds: Array
    """(r, 5) as `half_planes.add_rounds`: teammates and discs."""
    planes: Array
    """(p, 3) as `half_planes`; more rows than used."""
    plane_count: int
    held_count: int
    """So many rows of `planes` limit the velocity: for a vehicle with lag also the obstacles' from where it is now."""
    mate_modes: tuple[str, ...]
    flags: tuple[str, ...]
    """What of it is not as the method wants it."""


class Looking:
    """Makes situations; keeps the arrays that they share, so a situation is good until the next one."""

    def __init__(self, limits: Limits, parameters: EncirclementParameters) -> None:
        self._limits, self._parameters = limits, parameters
        self.kept_m = limits.body_radius_m + limits.safety_margin_m
        self._separation_m = parameters.team_separation_m or 2.0 * self.kept_m
        self.walls = polygons(parameters.polygons_m)
        self._lag_s = parameters.response_lag_s if parameters.vehicle == "multirotor" else 0.0
        self._braking_s = parameters.control_period_s
        if parameters.vehicle != "single-integrator":
            self._braking_s += parameters.reaction_s
        self._rounds = np.zeros((64, ROUND_COLUMNS))
        self._planes = np.zeros((64, PLANE_COLUMNS))

    def look(self, observation: Observation) -> Situation:
        """`observation` at its own time."""
        now, velocity = planar(observation.own.position_ned_m), planar(observation.own.velocity_ned_m_s)
        own = (now[0] + self._lag_s * velocity[0], now[1] + self._lag_s * velocity[1])
        evader = self._evader(observation)
        mates = [mate for mate in (self._mate(member, observation.t_s) for member in observation.team) if mate is not None]
        rows = self._rows(len(mates) + len(observation.obstacles.discs))
        count = 0
        for mate in mates:
            if mate.age_s < FORGOTTEN_S:
                rows[count] = self._round(mate)
                count += 1
        mate_count = count
        vehicles = [mate.place for mate in mates] + ([evader.place] if evader else [])
        count = self._add_discs(rows, count, observation, own, vehicles)
        self._planes = _grown(self._planes, 2 * (count + self.walls.count) + EDGES)
        filled = add_rounds(*own, rows, count, self._planes, 0)
        if self.walls.count:
            filled = add_polygons(*own, self.walls.corners, self.walls.starts, self.kept_m, self._planes, filled)
        filled = self._add_edges(own, filled)
        held = self._add_from_here(now, velocity, rows[mate_count:count], filled) if self._lag_s > 0.0 else filled
        counted = [now, *(mate.place for mate in mates if mate.age_s < self._parameters.mate_silent_s)]
        return Situation(
            t_s=observation.t_s,
            period_s=observation.dt_s if observation.dt_s > 0.0 else self._parameters.control_period_s,
            own=own,
            velocity=velocity,
            yaw_rad=observation.own.yaw_rad,
            evader=evader,
            team=np.array(counted),
            lag_s=self._lag_s,
            rounds=rows[:count],
            planes=self._planes,
            plane_count=filled,
            held_count=held,
            mate_modes=tuple(mate.mode for mate in mates),
            flags=self._flags(evader, mates, observation.obstacles.discs),
        )

    def _flags(self, evader: Evader | None, mates: list[Mate], discs: Array) -> tuple[str, ...]:
        """What of the observation the method does not count with, by name."""
        flags = []
        if evader is not None and evader.age_s > self._parameters.target_stale_s:
            flags.append("evader unseen")
        if any(mate.age_s > self._parameters.mate_stale_s for mate in mates):
            flags.append("teammate unheard")
        if discs.size and float(np.abs(discs[:, 3:5]).max()) > MOVING_M_S:
            flags.append("moving obstacle")
        return tuple(flags)

    def _add_from_here(self, now: Point, velocity: Point, discs: Array, filled: int) -> int:
        """The obstacles' planes from where the vehicle is: from where its lag puts it they may be turned out of its way.

        The room is less by what the lag flies towards each.
        """
        first = filled
        filled = add_rounds(*now, discs, len(discs), self._planes, filled)
        if self.walls.count:
            filled = add_polygons(*now, self.walls.corners, self.walls.starts, self.kept_m, self._planes, filled)
        planes = self._planes[first:filled]
        planes[:, 2] -= self._lag_s * np.maximum(0.0, planes[:, :2] @ np.array(velocity))
        return filled

    def _add_edges(self, own: Point, filled: int) -> int:
        """The edges of the area, as planes."""
        area = self._parameters.flight_area_m
        if area is None:
            return filled
        n, e = own
        edges = ((-1.0, 0.0, n - area[0]), (0.0, -1.0, e - area[1]), (1.0, 0.0, area[2] - n), (0.0, 1.0, area[3] - e))
        self._planes[filled : filled + EDGES] = edges
        return filled + EDGES

    def _rows(self, wanted: int) -> Array:
        self._rounds = _grown(self._rounds, wanted)
        return self._rounds

    def _evader(self, observation: Observation) -> Evader | None:
        track = observation.target
        if track is None or track.age_s >= self._parameters.target_lost_s or not _finite(track):
            return None
        ahead_s = min(max(0.0, observation.t_s - track.t_s), self._parameters.prediction_max_s)
        n, e = planar(track.position_ned_m)
        vn, ve = planar(track.velocity_ned_m_s)
        return Evader((n + ahead_s * vn, e + ahead_s * ve), (vn, ve), max(0.0, track.age_s))

    def _mate(self, member: TeamMember, t_s: float) -> Mate | None:
        """Where the teammate is by its last message; None if that is nonsense."""
        ahead_s = min(max(0.0, t_s - member.state.t_s), self._parameters.prediction_max_s)
        n, e, _ = member.state.position_ned_m.tolist()
        vn, ve, _ = member.state.velocity_ned_m_s.tolist()
        if not math.isfinite(n + e + vn + ve):
            return None
        return Mate((n + ahead_s * vn, e + ahead_s * ve), (vn, ve), max(0.0, member.age_s), member.name, member.mode)

    def _round(self, mate: Mate) -> tuple[float, float, float, float, float]:
        """A teammate shares the room between; one that has been silent too long is an obstacle as large as it may have come."""
        stale = mate.age_s > self._parameters.mate_stale_s
        uncertain_m = self._uncertain_m(mate) + 3.0 * self._parameters.position_sigma_m
        reach_m = self._separation_m + (1.0 if stale else 2.0) * uncertain_m
        n, e = mate.place[0] + self._lag_s * mate.velocity[0], mate.place[1] + self._lag_s * mate.velocity[1]
        return n, e, reach_m, DISC_SHARE if stale else MATE_SHARE, zlib.crc32(mate.name.encode()) / 2.0**32 * TWO_PI

    def _uncertain_m(self, mate: Mate) -> float:
        """How far the teammate can be from where it is believed to be: what it may have flown since, whatever it then did.

        A vehicle with inertia that is moved on by its velocity can only be off by what it has accelerated.
        """
        age_s = min(mate.age_s, self._parameters.mate_silent_s)
        flown_m = (self._limits.speed_max_m_s + math.hypot(*mate.velocity)) * age_s
        if self._parameters.vehicle == "single-integrator":
            return flown_m
        return min(flown_m, 0.5 * self._limits.acceleration_max_m_s2 * age_s * age_s)

    def _add_discs(self, rows: Array, count: int, observation: Observation, own: Point, vehicles: list[Point]) -> int:
        """Discs within range, moved to the present, that are no vehicles; a moving one with what it sweeps until one can stop."""
        discs = observation.obstacles.discs
        if not len(discs):
            return count
        parameters = self._parameters
        seen = np.array(discs[:, :5], dtype=np.float64)
        kept = np.isfinite(seen).all(axis=1) & (seen[:, 2] >= 0.0)
        swept_m: float | Array = self.kept_m + 3.0 * parameters.position_sigma_m
        if seen[:, 3:].any():
            seen[:, :2] += max(0.0, observation.t_s - observation.obstacles.t_s) * seen[:, 3:]
            speeds = np.hypot(seen[:, 3], seen[:, 4])
            swept_m = swept_m + speeds * self._braking_s + 0.5 * speeds**2 / self._limits.acceleration_max_m_s2
        kept &= np.hypot(seen[:, 0] - own[0], seen[:, 1] - own[1]) - seen[:, 2] <= parameters.obstacle_range_m
        if vehicles and parameters.vehicle_radius_max_m > 0.0:
            kept &= ~self._are_vehicles(seen, np.array(vehicles))
        seen[:, :2] += self._lag_s * seen[:, 3:]
        seen[:, 2] += swept_m
        found = seen[kept, :3]
        filled = rows[count : count + len(found)]
        filled[:, :3], filled[:, 3], filled[:, 4] = found, DISC_SHARE, 0.0
        return count + len(found)

    def _are_vehicles(self, discs: Array, vehicles: Array) -> Mask:
        near = discs[:, 2] + min(self._parameters.vehicle_disc_m, 0.9 * self._limits.body_radius_m)
        apart = np.hypot(discs[:, None, 0] - vehicles[:, 0], discs[:, None, 1] - vehicles[:, 1]).min(axis=1)
        found: Mask = (apart < near) & (discs[:, 2] <= self._parameters.vehicle_radius_max_m)
        return found


def _finite(moving: TargetTrack) -> bool:
    return math.isfinite(sum(planar(moving.position_ned_m)) + sum(planar(moving.velocity_ned_m_s)))


def _grown(rows: Array, wanted: int) -> Array:
    return rows if wanted <= len(rows) else np.zeros((2 * wanted, rows.shape[1]))
