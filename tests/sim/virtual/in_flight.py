"""One flight of `beside_a_tree.toml` in which something is broken at the worst moment, and everything that is judged afterwards.

The worst moment: the pursuer is in the terminal phase of its planner, less than 1 m from the tree, at speed.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.types import Decision, Observation
from flightapp.fleet.messages.command import Acknowledgement, Command
from flightapp.planning.api import Planner
from flightapp.recording.reader import read_recording
from flightapp.recording.sink import create_file
from flightapp.runtime.composition import build_strategy
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_script import Fault
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle
from flightapp.sim.virtual.mission import fly_virtual
from tests.sim.virtual.played import TREE_M, Played, evader_path

ROOT = Path(__file__).parents[3]
MISSION = Path(__file__).with_name("beside_a_tree.toml")
SIM = ROOT / "profiles/sim.toml"
TERMINAL = ("fine", "tracking")
BESIDE_M = 1.0
TREE_HEIGHT_M = 5.0
BODY_M = 0.35

PlannerFault = Callable[[Observation, Decision], Decision]


class BreakablePlanner:
    """The mission's own planner; `fault`, where there is one, has the last word."""

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self.fault: PlannerFault | None = None

    def step(self, observation: Observation) -> Decision:
        decision = self._planner.step(observation)
        return decision if self.fault is None else self.fault(observation, decision)

    def reset(self, seed: int | None = None) -> None:
        self._planner.reset(seed)


class Disk:
    """Where the recorders write; full from the moment on that `is_full` says so."""

    def __init__(self) -> None:
        self.is_full = False

    def open(self, path: Path) -> BinaryIO:
        file = create_file(path)
        write = file.write

        def write_if_room(data: Any) -> int:
            if self.is_full:
                raise OSError(28, "No space left on device")
            return write(data)

        return _Wrapped(file, write_if_room)  # type: ignore[return-value]


@dataclass(slots=True)
class _Wrapped:
    file: BinaryIO
    write: Callable[[Any], int]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


@dataclass(slots=True)
class Moment:
    """What a bystander sees at one time."""

    t_s: float
    mode: Mode
    phase: str
    speed_m_s: float
    position_ned_m: tuple[float, float, float]
    evader_m: float
    """To the evader, centre to centre."""


class _Lines(logging.Handler):
    """Log lines with their virtual time: what is left to read when nothing is recorded."""

    def __init__(self, flight: Flight) -> None:
        super().__init__()
        self._flight = flight

    def emit(self, record: logging.LogRecord) -> None:
        self._flight.lines.append((self._flight.now_s, record.getMessage()))


@dataclass
class Flight:
    """`breaking` is called once at the worst moment, or at `at_s` of mission time; the flight ends `watched_s` later."""

    breaking: Callable[[Flight], None]
    watched_s: float
    at_s: float | None = None
    then: Sequence[tuple[float, Callable[[Flight], None]]] = ()
    """What else happens, each a time after the worst moment, in order."""
    until: Callable[[Flight], bool] = lambda _: False
    """Ends the flight one second after it was first true."""
    path: Callable[[float], tuple[float, float, float]] = evader_path
    mission: Path = MISSION
    evader: Played = field(default_factory=lambda: Played("e1", "evader", 3))
    teammate: Played = field(default_factory=lambda: Played("p2", "pursuer", 2))
    disk: Disk = field(default_factory=Disk)
    broken_s: float = math.inf
    now_s: float = 0.0
    moments: list[Moment] = field(default_factory=list)
    lines: list[tuple[float, str]] = field(default_factory=list)
    answers: list[Callable[[], list[Acknowledgement]]] = field(default_factory=list)
    fleet: VirtualFleet = field(init=False)
    planner: BreakablePlanner = field(init=False)
    run: Path = field(init=False)
    _happened: int = 0
    _recorded: Sequence[Mapping[str, Any]] | None = None

    @property
    def one(self) -> VirtualVehicle:
        return self.fleet.vehicles["p1"]

    def fly(self, run: Path) -> Flight:
        """To the end; the recording stands in `run`."""
        self.run = run
        mission = load_mission(self.mission)
        vehicle = mission.vehicle("p1")
        self.planner = BreakablePlanner(build_strategy(mission, vehicle, load_profile(SIM), self.mission, 0))
        log, lines = logging.getLogger("p1"), _Lines(self)
        level = log.level
        log.addHandler(lines)
        log.setLevel(logging.INFO)
        try:
            fly_virtual(
                self.mission,
                SIM,
                run,
                watch=self._watch,
                strategies={"p1": self.planner},
                flown=["p1"],
                open_file=self.disk.open,
                time_limit_s=120.0,
            )
        finally:
            log.removeHandler(lines)
            log.setLevel(level)
        return self

    def fault(self, target: str, verb: str, **fields: Any) -> None:
        """Break a part of the autopilot, now."""
        self.one.faults.add(Fault.model_validate({"target": target, "verb": verb, "at_s": 0.0, **fields}))

    def command(self, action: str) -> None:
        """An operator's command, now."""
        command = Command(action, f"{action}-{self.now_s}", self.now_s, "Ann")
        self.answers.append(self.fleet.network.command(self.fleet.mission.fleet, "p1", command))

    def fault_was_felt(self) -> bool:
        return any(event["event"] == "fault_felt" for event in self.one.events)

    def was_accepted(self) -> bool:
        return bool(self.answers) and all(answer.accepted for ask in self.answers for answer in ask())

    def events(self, name: str) -> list[Mapping[str, Any]]:
        """The recorded events `name`, in order."""
        if self._recorded is None:
            self._recorded = read_recording(self.run / "p1.mcap").topic("/event").messages
        return [message for message in self._recorded if message["name"] == name]

    def moment_at(self, t_s: float) -> Moment:
        return next(moment for moment in self.moments if moment.t_s >= t_s)

    def since(self, t_s: float) -> list[Moment]:
        return [moment for moment in self.moments if moment.t_s >= t_s]

    def mode_since_s(self, mode: Mode, t_s: float) -> float:
        """When `mode` was first flown from `t_s` on."""
        return next((moment.t_s for moment in self.moments if moment.t_s >= t_s and moment.mode is mode), math.inf)

    def _watch(self, fleet: VirtualFleet) -> None:
        self.fleet = fleet
        self.now_s = fleet.clock.now_s()
        self.evader.play(fleet, self.path(self.now_s - 1000.0))
        self.teammate.play(fleet, (-2.0, 9.0, -2.5))
        one = self.one
        north, east, down = one.position_ned_m.tolist()
        speed = math.hypot(*one.velocity_ned_m_s.tolist())
        evader_m = math.dist((north, east), self.evader.position_ned_m[:2])
        self.moments.append(Moment(self.now_s, one.station.core.mode, one.loop.phase, speed, (north, east, down), evader_m))
        if math.isinf(self.broken_s) and self._is_worst(one, speed):
            self.broken_s = self.now_s
            self.breaking(self)
        while self._happened < len(self.then) and self.now_s > self.broken_s + self.then[self._happened][0]:
            self._happened += 1
            self.then[self._happened - 1][1](self)
        if self.now_s > self.broken_s and self.until(self):
            self.watched_s = min(self.watched_s, self.now_s - self.broken_s + 1.0)
        if self.now_s > self.broken_s + self.watched_s:
            fleet.stop()

    def _is_worst(self, one: VirtualVehicle, speed_m_s: float) -> bool:
        if self.at_s is not None:
            return self.now_s >= 1000.0 + self.at_s
        decision = one.loop.decision
        return decision is not None and decision.mode in TERMINAL and clearance_m(self.moments[-1]) < BESIDE_M and speed_m_s > 1.5


def clearance_m(moment: Moment) -> float:
    """Body to tree, m; infinite above the tree."""
    north, east, down = moment.position_ned_m
    if -down > TREE_HEIGHT_M + BODY_M:
        return math.inf
    return math.hypot(north - TREE_M[0], east - TREE_M[1]) - TREE_M[2] - BODY_M
