"""What one pursuer makes of an observation: planes of all that it must not touch, places of the team, the evader."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array, Limits, Observation, TargetTrack, TeamMember, VehicleState
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.planning.geometry.half_planes import PLANE_COLUMNS, ROUND_COLUMNS, add_polygons, add_rounds
from flightapp.planning.geometry.polygons import polygons
from flightapp.planning.plane import Point, planar

FORGOTTEN_S = 10.0
"""A teammate's last place is kept clear of no longer than this."""
ALREADY_MOVED_S = 1e-6


@dataclass(frozen=True, slots=True)
class Evader:
    """Where the evader is believed to be."""

    place: Point
    velocity: Point
    age_s: float


@dataclass(frozen=True, slots=True)
class Situation:
    """One control period, before anything is decided. Lengths in m, mission frame, (north, east)."""

    t_s: float
    period_s: float
    own: Point
    velocity: Point
    yaw_rad: float
    evader: Evader | None
    team: Array
    """(k, 2): the own place first, then of every teammate that still counts."""
    rounds: Array
    """(r, 5) as `half_planes.add_rounds`: teammates and discs."""
    planes: Array
    """(p, 3) as `half_planes`; more rows than used."""
    plane_count: int
    mate_modes: tuple[str, ...]


class Looking:
    """Makes situations; keeps the arrays that they share, so a situation is good until the next one."""

    def __init__(self, limits: Limits, parameters: EncirclementParameters) -> None:
        self._limits, self._parameters = limits, parameters
        self._kept_m = limits.body_radius_m + limits.safety_margin_m
        self._separation_m = parameters.team_separation_m or 2.0 * self._kept_m
        self._polygons = polygons(parameters.polygons_m)
        self._rounds = np.zeros((64, ROUND_COLUMNS))
        self._planes = np.zeros((64, PLANE_COLUMNS))

    def look(self, observation: Observation) -> Situation:
        """`observation` at its own time."""
        own = planar(observation.own.position_ned_m)
        evader = self._evader(observation)
        mates = [(member, self._place(member, observation.t_s)) for member in observation.team if _finite(member.state)]
        rows = self._rows(len(mates) + len(observation.obstacles.discs))
        count = 0
        for member, place in mates:
            if member.age_s < FORGOTTEN_S:
                self._add_mate(rows[count], member, place)
                count += 1
        vehicles = [place for _, place in mates] + ([evader.place] if evader else [])
        count = self._add_discs(rows, count, observation, own, vehicles)
        self._planes = _grown(self._planes, count + self._polygons.count)
        filled = add_rounds(*own, rows, count, self._planes, 0)
        if self._polygons.count:
            filled = add_polygons(*own, self._polygons.corners, self._polygons.starts, self._kept_m, self._planes, filled)
        counted = [own, *(place for member, place in mates if member.age_s < self._parameters.mate_silent_s)]
        return Situation(
            t_s=observation.t_s,
            period_s=observation.dt_s if observation.dt_s > 0.0 else self._parameters.control_period_s,
            own=own,
            velocity=planar(observation.own.velocity_ned_m_s),
            yaw_rad=observation.own.yaw_rad,
            evader=evader,
            team=np.array(counted),
            rounds=rows[:count],
            planes=self._planes,
            plane_count=filled,
            mate_modes=tuple(member.mode for member, _ in mates),
        )

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

    def _place(self, member: TeamMember, t_s: float) -> Point:
        """Where the teammate is by its last message."""
        ahead_s = min(max(0.0, t_s - member.state.t_s), self._parameters.prediction_max_s)
        n, e = planar(member.state.position_ned_m)
        vn, ve = planar(member.state.velocity_ned_m_s)
        return n + ahead_s * vn, e + ahead_s * ve

    def _add_mate(self, row: Array, member: TeamMember, place: Point) -> None:
        """A teammate shares the room between; one that has been silent too long is an obstacle as large as it may have come."""
        uncertain_m = self._uncertain_m(member) + 3.0 * self._parameters.position_sigma_m
        tie_rad = zlib.crc32(member.name.encode()) / 2.0**32 * 2.0 * math.pi
        stale = member.age_s > self._parameters.mate_stale_s
        row[:] = (
            *place,
            self._separation_m + (1.0 if stale else 2.0) * uncertain_m,
            1.0 if stale else 0.5,
            tie_rad,
        )

    def _uncertain_m(self, member: TeamMember) -> float:
        """How far the teammate can be from where it is believed to be: what it may have flown since, whatever it then did.

        A vehicle with inertia that is moved on by its velocity can only be off by what it has accelerated.
        """
        age_s = min(max(0.0, member.age_s), self._parameters.mate_silent_s)
        speed = math.hypot(*planar(member.state.velocity_ned_m_s))
        flown_m = (self._limits.speed_max_m_s + speed) * age_s if speed > 0.0 else self._limits.speed_max_m_s * age_s
        if self._parameters.vehicle == "single-integrator":
            return flown_m
        return min(flown_m, 0.5 * self._limits.acceleration_max_m_s2 * age_s * age_s)

    def _add_discs(self, rows: Array, count: int, observation: Observation, own: Point, vehicles: list[Point]) -> int:
        """Discs within range, moved to the present, that are no vehicles; a moving one with what it sweeps until one can stop."""
        parameters, limits = self._parameters, self._limits
        age_s = max(0.0, observation.t_s - observation.obstacles.t_s)
        braking_s = parameters.control_period_s
        if parameters.vehicle != "single-integrator":
            braking_s += parameters.reaction_s
        for n, e, radius, vn, ve, _, _ in observation.obstacles.discs.tolist():
            if not math.isfinite(n + e + radius + vn + ve) or radius < 0.0:
                continue
            n, e = n + age_s * vn, e + age_s * ve
            distance = math.hypot(n - own[0], e - own[1])
            if distance - radius > parameters.obstacle_range_m or self._is_vehicle(n, e, radius, vehicles):
                continue
            swept_m = 0.0
            if vn != 0.0 or ve != 0.0:
                speed = math.hypot(vn, ve)
                swept_m = speed * braking_s + 0.5 * speed * speed / limits.acceleration_max_m_s2
            rows[count] = n, e, radius + self._kept_m + swept_m + 3.0 * parameters.position_sigma_m, 1.0, 0.0
            count += 1
        return count

    def _is_vehicle(self, n: float, e: float, radius: float, vehicles: list[Point]) -> bool:
        if radius > self._parameters.vehicle_radius_max_m:
            return False
        near = radius + min(self._parameters.vehicle_disc_m, 0.9 * self._limits.body_radius_m)
        return any(math.hypot(n - place[0], e - place[1]) < near for place in vehicles)


def _finite(moving: TargetTrack | VehicleState) -> bool:
    return all(map(math.isfinite, (*planar(moving.position_ned_m), *planar(moving.velocity_ned_m_s))))


def _grown(rows: Array, wanted: int) -> Array:
    return rows if wanted <= len(rows) else np.zeros((2 * wanted, rows.shape[1]))
