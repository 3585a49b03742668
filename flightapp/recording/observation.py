"""What planner and supervisor are given in one control period, as a record and back, bit for bit.

JSON numbers are written in the shortest form that reads back as the same double. Infinity and NaN become null, and null NaN.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import (
    Array,
    Assignment,
    Boundary,
    Observation,
    ObstacleSet,
    Rendezvous,
    TargetTrack,
    TeamMember,
    VehicleState,
)
from flightapp.recording.messages import ObservationRecord, ObservedMember, ObservedTarget
from flightapp.safety.api import SafetyContext

COVARIANCE_SIZE = 6
_UPPER = np.triu_indices(COVARIANCE_SIZE)


def observation_record(
    observation: Observation, context: SafetyContext, frame_number: int | None, *, planned: bool, held: bool
) -> ObservationRecord:
    """`observation` and what the supervisor is told besides; `frame_number` of the depth frame that its obstacles are of.

    The planner's obstacles are the supervisor's, and after those what mates have told.
    """
    own = observation.own
    taking_part = {member.name for member in observation.team}
    return ObservationRecord(
        observation.t_s,
        observation.dt_s,
        planned,
        held,
        own.position_ned_m.tolist(),
        own.velocity_ned_m_s.tolist(),
        own.yaw_rad,
        context.own_age_s,
        [_member_record(member, member.name in taking_part) for member in context.team],
        None if observation.target is None else _target_record(observation.target),
        frame_number,
        observation.obstacles.t_s,
        context.team_link_age_s,
        context.battery_fraction,
        None if observation.assignment is None else observation.assignment.bearing_rad,
        None if observation.assignment is None else observation.assignment.arrival_s,
        None if observation.assignment is None else _rendezvous_record(observation.assignment.rendezvous),
        observation.obstacles.discs[len(context.obstacles.discs) :, :3].tolist() or None,
        None if context.heights_trusted else False,
    )


@dataclass(frozen=True, slots=True)
class Given:
    """One record read back: what the planner was given, and what the supervisor was told besides."""

    observation: Observation
    obstacles: ObstacleSet
    """The supervisor's: of the own camera alone."""
    team: tuple[TeamMember, ...]
    own_age_s: float
    team_link_age_s: float | None
    battery_fraction: float | None
    heights_trusted: bool


def given_by(record: ObservationRecord, obstacles: ObstacleSet, boundary: Boundary) -> Given:
    """`record` with the obstacles that it refers to; ValueError where it cannot be."""
    team = tuple(_member(member, record.t_s) for member in record.team)
    own = VehicleState(
        record.t_s, vector(record.own_position_ned_m), vector(record.own_velocity_ned_m_s), number(record.own_yaw_rad)
    )
    observation = Observation(
        t_s=record.t_s,
        dt_s=record.dt_s,
        own=own,
        team=tuple(member for member, told in zip(team, record.team, strict=True) if told.takes_part),
        target=None if record.target is None else _target(record.target),
        obstacles=obstacles.with_standing(_places(record.told_discs or [])),
        boundary=boundary,
        assignment=_assignment(record),
    )
    trusted = record.heights_trusted is not False
    return Given(observation, obstacles, team, _age(record.own_age_s), record.team_link_age_s, record.battery_fraction, trusted)


def vector(numbers: Sequence[float | None]) -> Array:
    """Recorded numbers as an array."""
    return np.array([number(value) for value in numbers], dtype=np.float64)


def number(value: float | None) -> float:
    """A recorded number; NaN where it is null."""
    return math.nan if value is None else value


def _member_record(member: TeamMember, takes_part: bool) -> ObservedMember:
    state = member.state
    return ObservedMember(
        member.name,
        state.position_ned_m.tolist(),
        state.velocity_ned_m_s.tolist(),
        state.yaw_rad,
        member.mode,
        member.eta_s,
        member.age_s,
        takes_part,
    )


def _member(record: ObservedMember, t_s: float) -> TeamMember:
    state = VehicleState(t_s, vector(record.position_ned_m), vector(record.velocity_ned_m_s), number(record.yaw_rad))
    return TeamMember(record.name, state, record.mode, record.eta_s, _age(record.age_s))


def _assignment(record: ObservationRecord) -> Assignment | None:
    if record.assignment_bearing_rad is None or record.assignment_arrival_s is None:
        return None
    return Assignment(record.assignment_bearing_rad, record.assignment_arrival_s, _rendezvous(record.assignment_rendezvous))


def _rendezvous_record(at: Rendezvous | None) -> list[float] | None:
    if at is None:
        return None
    flags = float(at.closing), float(at.reachable)
    return [at.north_m, at.east_m, at.heading_rad, at.radius_m, float(at.slots), float(at.slot), *flags]


def _rendezvous(numbers: list[float] | None) -> Rendezvous | None:
    if numbers is None:
        return None
    north_m, east_m, heading_rad, radius_m, slots, slot, closing, *later = numbers
    return Rendezvous(north_m, east_m, heading_rad, radius_m, round(slots), round(slot), bool(closing), later != [0.0])


def _target_record(track: TargetTrack) -> ObservedTarget:
    covariance = track.covariance
    symmetric = bool((covariance == covariance.T).all())
    return ObservedTarget(
        track.t_s,
        track.position_ned_m.tolist(),
        track.velocity_ned_m_s.tolist(),
        (covariance[_UPPER] if symmetric else covariance.ravel()).tolist(),
        track.age_s,
    )


def _target(record: ObservedTarget) -> TargetTrack:
    return TargetTrack(
        record.t_s,
        vector(record.position_ned_m),
        vector(record.velocity_ned_m_s),
        _covariance(record.covariance),
        _age(record.age_s),
    )


def _places(rows: list[list[float]]) -> Array:
    if any(len(row) != 3 for row in rows):
        raise ValueError("told_discs: each row must be north_m, east_m, radius_m")
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _covariance(numbers: Sequence[float | None]) -> Array:
    values = np.array([number(value) for value in numbers])
    if len(values) == COVARIANCE_SIZE**2:
        return values.reshape(COVARIANCE_SIZE, COVARIANCE_SIZE)
    covariance = np.zeros((COVARIANCE_SIZE, COVARIANCE_SIZE))
    covariance[_UPPER] = values
    covariance.T[_UPPER] = values
    return covariance


def _age(value: float | None) -> float:
    return math.inf if value is None else value
