"""One mission of the campaign: planned, flown, judged."""

from __future__ import annotations

import logging
import random
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import psutil
import tomli_w

from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError
from flightapp.recording.reader import Recording, read_recording
from flightapp.recording.recover import recover
from flightapp.runtime.composition import build_strategy
from flightapp.sim.fault_campaign.broken_disk import BreakableDisk
from flightapp.sim.fault_campaign.drawing import draw
from flightapp.sim.fault_campaign.effects import BreakablePlanner, Site
from flightapp.sim.fault_campaign.invariants import INVARIANTS
from flightapp.sim.fault_campaign.observer import Observer, columns, is_piloted
from flightapp.sim.fault_campaign.plan import Plan
from flightapp.sim.fault_campaign.trace import RecordingCheck, SentSetpoint, Trace, VehicleTrace
from flightapp.sim.virtual.event_loop import START_S
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle
from flightapp.sim.virtual.mission import fly_virtual

TIME_LIMIT_S = 400.0
LOST_AT_MOST = 0.3
"""Share of a killed vehicle's recording that is cut off, at most: what had not reached the disk."""


@dataclass(frozen=True, slots=True)
class Violation:
    """An invariant that did not hold. `time_s` since the start of the simulation; `recording`: within the output folder."""

    seed: int
    invariant: str
    vehicle: str
    time_s: float | None
    text: str
    recording: str


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of one seed; equal for equal seeds."""

    seed: int
    mission_s: float
    outcomes: tuple[tuple[str, str], ...]
    """(vehicle, outcome)."""
    injections: tuple[tuple[str, str, str], ...]
    """(kind, vehicle, felt / not felt / not begun)."""
    violations: tuple[Violation, ...]

    def as_json(self) -> dict[str, object]:
        return asdict(self)


def fly_seed(seed: int, mission_path: Path, profile_path: Path, folder: Path, *, varies: bool) -> Verdict:
    """Fly `seed`; its recordings and its mission go to the new folder `folder`."""
    plan = draw(seed, load_mission(mission_path), varies=varies)
    folder.mkdir(parents=True)
    if varies:
        mission_path = folder / "mission.toml"
        mission_path.write_text(tomli_w.dumps(plan.mission.model_dump(mode="json", exclude_none=True)))
    try:
        with _quiet():
            trace = _flown(plan, mission_path, profile_path, folder)
    except Exception as error:  # The simulation itself broke: that is a finding, not the end of the campaign.
        where = traceback.extract_tb(error.__traceback__)[-1]
        text = f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
        broken = Violation(seed, "no crash", "", None, text, _recording(folder, ""))
        planned = tuple((one.kind, one.vehicle, "not begun") for one in plan.injections)
        return Verdict(seed, 0.0, (), planned, (broken,))
    return judge(trace, folder)


def judge(trace: Trace, folder: Path) -> Verdict:
    """Every invariant held against `trace`."""
    violations = [
        Violation(trace.seed, name, found.vehicle, _rounded(found.time_s), found.text, _recording(folder, found.vehicle))
        for name, invariant in INVARIANTS.items()
        for found in invariant(trace)
    ]
    return Verdict(
        seed=trace.seed,
        mission_s=round(max(float(one.states[-1, 0]) for one in trace.vehicles.values()), 2),
        outcomes=tuple((one.name, one.outcome) for one in trace.vehicles.values()),
        injections=tuple((one.kind, one.vehicle, one.outcome) for one in trace.injections),
        violations=tuple(violations),
    )


def _recording(folder: Path, vehicle: str) -> str:
    return f"{folder.name}/{vehicle}.mcap" if vehicle else folder.name


def _rounded(time_s: float | None) -> float | None:
    return None if time_s is None else round(time_s, 3)


def _flown(plan: Plan, mission_path: Path, profile_path: Path, folder: Path) -> Trace:
    mission, profile = plan.mission, load_profile(profile_path)
    planners = {
        vehicle.name: BreakablePlanner(build_strategy(mission, vehicle, profile, mission_path, plan.seed))
        for vehicle in mission.vehicles
    }
    disks = {vehicle.name: BreakableDisk() for vehicle in mission.vehicles}
    observer = Observer(plan, planners, disks)
    fleet = fly_virtual(
        mission_path,
        profile_path,
        folder,
        seed=plan.seed,
        watch=observer.watch,
        strategies=dict(planners),
        time_limit_s=TIME_LIMIT_S,
        open_file=lambda path: disks[path.stem].open_file(path),
    )
    return _trace(plan, mission, fleet, observer, folder)


def _trace(plan: Plan, mission: Mission, fleet: VirtualFleet, observer: Observer, folder: Path) -> Trace:
    reports = observer.reports()
    killed = {one.vehicle for one in reports if one.kind in ("killed", "hung") and one.felt_s is not None}
    vehicles = {}
    for name, one in fleet.vehicles.items():
        site, recording = observer.sites[name], _readable(folder / f"{name}.mcap")
        states, armed, on_ground = columns(observer.samples[name])
        vehicles[name] = VehicleTrace(
            vehicle=one.vehicle,
            limits=one.rooms.limits,
            states=states,
            armed=armed,
            on_ground=on_ground,
            setpoints=_setpoints(one, site, recording),
            transmitted_s=_true_times(one.autopilot.transmitted_s, [(step[1], step[3]) for step in site.clock_steps]),
            commands=_commands(one, site),
            takeovers=site.takeovers,
            wishes=site.wishes,
            outcome="" if one.outcome is None else one.outcome.value,
            error=one.error,
            is_piloted=is_piloted(site),
            crashes=list(_crashes(one)),
            recordings=[] if _never_written(site) else [_check(folder / f"{name}.mcap", recording)],
            is_recorded=not _never_written(site),
        )
        if name in killed:
            vehicles[name].recordings.append(_cut_and_recovered(folder / f"{name}.mcap", plan.seed))
    return Trace(plan.seed, mission, vehicles, reports, list(_leftovers()))


def _true_times(times_s: list[float], steps: list[tuple[int, float]]) -> list[float]:
    """The vehicle's own time stamps as seconds since the start; `steps`: from this number on its clock was ahead by so much."""
    true = []
    for number, t_s in enumerate(times_s):
        ahead_s = sum(step_s for first, step_s in steps if number >= first)
        true.append(t_s - ahead_s - START_S)
    return true


def _setpoints(one: VirtualVehicle, site: Site, recording: Recording | None) -> list[SentSetpoint]:
    guards: dict[float, tuple[str, ...]] = {}
    if recording is not None:
        guards = {
            message["t_s"]: tuple(name for name, _ in message["acting"]) for message in recording.topic("/setpoint").messages
        }
    stamps = [t_s for t_s, _ in one.autopilot.sent]
    true = _true_times(stamps, [(step[0], step[3]) for step in site.clock_steps])
    sent = []
    for t_s, stamp_s, (_, setpoint) in zip(true, stamps, one.autopilot.sent, strict=True):
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        sent.append(SentSetpoint(t_s, (north, east, down), setpoint.yaw_rad, guards.get(stamp_s)))
    return sent


def _commands(one: VirtualVehicle, site: Site) -> list[tuple[float, str]]:
    true = _true_times([t_s for t_s, _ in one.autopilot.commands], [(step[2], step[3]) for step in site.clock_steps])
    return [(t_s, what) for t_s, (_, what) in zip(true, one.autopilot.commands, strict=True)]


def _crashes(one: VirtualVehicle) -> Iterator[str]:
    for task in one.tasks:
        if not task.done():
            yield f"a task did not end: {task.get_coro()}"
        elif not task.cancelled() and (error := task.exception()) is not None:
            yield f"{type(error).__name__}: {error}"
    if one.loop.failure is not None:
        yield f"control period failed: {one.loop.failure}"


def _leftovers() -> Iterator[str]:
    for thread in threading.enumerate():
        if thread.name == "recorder":
            yield "a recorder's thread lives on"
    for process in psutil.Process().children():
        with suppress(psutil.Error):  # It has ended meanwhile.
            if "flightapp" in " ".join(process.cmdline()):
                yield f"a process lives on: {process.name()}"


def _readable(path: Path) -> Recording | None:
    try:
        return read_recording(path)
    except InputError:
        return None


def _never_written(site: Site) -> bool:
    """The disk was full before anything had reached it: there is nothing to read."""
    return site.disk.is_full and site.one.recorder.path.stat().st_size == 0


def _check(path: Path, recording: Recording | None) -> RecordingCheck:
    messages = 0 if recording is None else sum(len(series) for series in recording.series.values())
    return RecordingCheck(path, messages, "cannot be read" if recording is None else "")


def _cut_and_recovered(path: Path, seed: int) -> RecordingCheck:
    """What a killed process leaves: the file without its end, made good by `flightapp recover`."""
    content = path.read_bytes()
    kept = 1.0 - random.Random(f"cut {seed}").uniform(0.0, LOST_AT_MOST)
    cut, recovered = path.with_suffix(".cut.mcap"), path.with_suffix(".recovered.mcap")
    cut.write_bytes(content[: round(kept * len(content))])
    try:
        found = recover(cut, recovered)
        return RecordingCheck(recovered, found.messages, "")
    except InputError as error:
        return RecordingCheck(cut, 0, str(error))


@contextmanager
def _quiet() -> Iterator[None]:
    """The vehicles' events are in their recordings, not on the terminal."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)
