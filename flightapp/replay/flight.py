"""What one recording says of its flight, as far as deciding it again takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

import flightapp
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.errors import InputError
from flightapp.core.types import Array, Boundary, Decision, ObstacleSet, Setpoint
from flightapp.recording.attachments import attached
from flightapp.recording.messages import DecisionRecord, ObservationRecord, SetpointRecord
from flightapp.recording.observation import Given, given_by, number, vector
from flightapp.recording.reader import Recording, Series, discs_of, read_recording
from flightapp.runtime.composition import surveyed_obstacles
from flightapp.runtime.recorded_inputs import MISSION_FILE, PROFILE_FILE
from flightapp.runtime.velocity_loop import EVENT as VELOCITY_LOOP
from flightapp.vehicle.velocity_gains import VelocityGains

Record = TypeVar("Record")


@dataclass(frozen=True, slots=True)
class Sent:
    """A recorded setpoint, what the supervisor had been asked for, and who changed it."""

    wish: Setpoint
    setpoint: Setpoint
    acting: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Tick:
    """One control period: what was given, and what came of it. `decision` is None where the planner was not asked or failed."""

    t_s: float
    planned: bool
    held: bool
    starts_pursuit: bool
    given: Given | None
    """None where the recorder has dropped the obstacles that belong to it."""
    previous: Setpoint | None
    decision: Decision | None
    sent: Sent | None

    @property
    def flown_by_planner(self) -> bool:
        """Whether the planner's decision became the setpoint."""
        return self.decision is not None and not self.held


@dataclass(frozen=True, slots=True)
class Flight:
    """One vehicle's recording, ready to be decided again. `boundary` is one object, as in flight."""

    recording: Recording
    mission: Mission
    profile: Profile
    vehicle: Vehicle
    seed: int
    ticks: tuple[Tick, ...]
    velocity_gains: VelocityGains | None = None
    """Of the autopilot's velocity loop, where a controller flew over it and they were recorded."""


def read_flight(path: Path) -> Flight:
    """The flight in `path`; InputError with one sentence where it cannot be decided again."""
    recording = read_recording(path)
    about = recording.metadata.get("run", {})
    _check_version(path, about.get("flightapp"))
    if not len(recording.topic("/observation")):
        if len(recording.topic("/setpoint")):
            raise InputError(f"{path}: has no /observation channel: recorded before flights could be decided again")
        raise InputError(f"{path}: nothing was decided in this recording: no setpoint was sent")
    mission = attached(Mission, recording, MISSION_FILE)
    profile = attached(Profile, recording, PROFILE_FILE)
    names = [vehicle.name for vehicle in mission.vehicles]
    if recording.vehicle not in names:
        raise InputError(f"{path}: is of '{recording.vehicle}', which the attached mission does not have: {', '.join(names)}")
    seed = about.get("seed", "0")
    if not seed.isdecimal():
        raise InputError(f"{path}: metadata run: seed = '{seed}': must be a whole number")
    ticks = _Reader(recording, mission.boundary.as_boundary(), surveyed_obstacles(mission)).ticks()
    gains = _velocity_gains(recording)
    return Flight(recording, mission, profile, mission.vehicle(recording.vehicle), int(seed), ticks, gains)


def _velocity_gains(recording: Recording) -> VelocityGains | None:
    for message in recording.topic("/event").messages:
        if message["name"] == VELOCITY_LOOP:
            return VelocityGains(float(message["data"]["planar_1_s"]), float(message["data"]["vertical_1_s"]))
    return None


def _check_version(path: Path, version: str | None) -> None:
    if version is None:
        return
    ours = flightapp.__version__
    if version.partition(".")[0] != ours.partition(".")[0]:
        raise InputError(
            f"{path}: recorded by flightapp {version}; this is {ours}, which decides flights of its own major version"
        )


class _Reader:
    """Puts together what was recorded on several channels."""

    def __init__(self, recording: Recording, boundary: Boundary, surveyed: ObstacleSet) -> None:
        self._path = recording.path
        self._recording = recording
        self._boundary = boundary
        self._surveyed = surveyed
        frames = recording.topic("/obstacles")
        self._frames = frames
        numbers, times = frames.column("frame_number").tolist(), frames.values("frame_t_s")
        self._places = {key: place for place, key in enumerate(zip(numbers, times, strict=True))}
        self._newest: tuple[int, ObstacleSet] | None = None

    def ticks(self) -> tuple[Tick, ...]:
        observed = self._recording.topic("/observation")
        records = [self._as(ObservationRecord, observed, place) for place in range(len(observed))]
        decided = self._recording.topic("/decision")
        decisions = {t_s: place for place, t_s in enumerate(decided.values("t_s"))}
        starts = self._pursuits()
        sent = self._sent(observed.t_s)
        previous: Setpoint | None = None
        ticks = []
        for place, record in enumerate(records):
            found = decisions.get(record.t_s)
            decision = None if found is None else _decision(self._as(DecisionRecord, decided, found))
            starting = bool(starts) and observed.t_s[place] >= starts[0] and record.planned
            if starting:
                starts.pop(0)
            ticks.append(
                Tick(record.t_s, record.planned, record.held, starting, self._given(record), previous, decision, sent[place])
            )
            made = sent[place]
            previous = previous if made is None else made.setpoint
        return tuple(ticks)

    def _pursuits(self) -> list[float]:
        """When the planner was made to forget: at the start of a pursuit."""
        phases = self._recording.topic("/phase")
        names = phases.texts("phase")
        return [
            t_s
            for t_s, name, before in zip(phases.t_s.tolist(), names, ["", *names], strict=False)
            if name == "pursue" and before != "pursue"
        ]

    def _sent(self, ticks_s: Array) -> list[Sent | None]:
        """The setpoint of every tick: the first between it and the next."""
        series = self._recording.topic("/setpoint")
        found: list[Sent | None] = [None] * len(ticks_s)
        tick_of = np.searchsorted(ticks_s, series.t_s, side="right") - 1
        for place, tick in enumerate(tick_of.tolist()):
            if tick >= 0 and found[tick] is None:
                found[tick] = _sent(self._as(SetpointRecord, series, place), self._path)
        return found

    def _given(self, record: ObservationRecord) -> Given | None:
        obstacles = self._obstacles(record)
        if obstacles is None:
            return None
        try:
            return given_by(record, obstacles, self._boundary)
        except ValueError as error:
            raise InputError(f"{self._path}: /observation at {record.t_s:.3f} s: {error}") from None

    def _obstacles(self, record: ObservationRecord) -> ObstacleSet | None:
        t_s = record.obstacles_t_s
        if record.frame_number is None:
            if t_s == record.t_s:
                return ObstacleSet(t_s, self._surveyed.discs, self._surveyed.unseen)
            return ObstacleSet(t_s, np.zeros((0, 7)), np.array([[-np.pi, np.pi]]))
        place = self._places.get((float(record.frame_number), t_s))
        if place is None:
            return None
        if self._newest is None or self._newest[0] != place:
            message = self._frames.messages[place]
            unseen = np.array(message["unseen_rad"], dtype=np.float64).reshape(-1, 2)
            self._newest = place, ObstacleSet(t_s, discs_of(message), unseen)
        return self._newest[1]

    def _as(self, kind: type[Record], series: Series, place: int) -> Record:
        try:
            return msgspec.convert(series.messages[place], kind)
        except msgspec.ValidationError as error:
            raise InputError(f"{self._path}: {series.topic}, message {place + 1}: {error}") from None


def _decision(record: DecisionRecord) -> Decision:
    goal = None if record.goal_ned_m is None else vector(record.goal_ned_m)
    return Decision(
        vector(record.velocity_ned_m_s), None, number(record.yaw_rad), record.mode, goal, record.reason, record.diagnostics
    )


def _sent(record: SetpointRecord, path: Path) -> Sent:
    if record.wish_ned_m_s is None:
        raise InputError(f"{path}: /setpoint at {record.t_s:.3f} s does not say what the supervisor was asked for")
    forward = None if record.acceleration_ned_m_s2 is None else np.array(record.acceleration_ned_m_s2)
    return Sent(
        Setpoint(vector(record.wish_ned_m_s), number(record.wish_yaw_rad)),
        Setpoint(np.array(record.velocity_ned_m_s), record.yaw_rad, forward),
        tuple((guard, reason) for guard, reason in record.acting),
    )
