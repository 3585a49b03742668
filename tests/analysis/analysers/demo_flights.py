"""Flights of the demo mission on the virtual clock, clean and with faults, and recordings changed message by message."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import orjson
from mcap.records import Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from flightapp.analysis.analysers import ANALYSERS
from flightapp.analysis.analysers.analyser import examine_run
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.run import load_run
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.types import Decision, Observation
from flightapp.planning.api import Planner
from flightapp.recording.recorder import FILE_PROFILE
from flightapp.recording.scan import Scan
from flightapp.runtime.composition import build_strategy
from flightapp.sim.fault_campaign.broken_disk import BreakableDisk
from flightapp.sim.fault_campaign.effects import BreakablePlanner, Effect, Site
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).resolve().parents[3]
MISSION, PROFILE = ROOT / "missions" / "demo_two_pursuers.toml", ROOT / "profiles" / "sim.toml"
SEED = 2


@dataclass(frozen=True)
class Injection:
    """One effect on one vehicle, from `at_s` after the start of its pursuit on (None: from the first step) for `lasts_s`."""

    vehicle: str
    at_s: float | None
    lasts_s: float
    effect: Effect


class Flapping(BreakablePlanner):
    """Changes between two modes and two directions while its fault is "flaps"."""

    def step(self, observation: Observation) -> Decision:
        if self.fault != "flaps":
            return super().step(observation)
        self.felt = self.fault
        decision = self._planner.step(observation)
        ahead = int(observation.t_s / 0.4) % 2 == 0
        return replace(decision, velocity_ned_m_s=np.array([3.0 if ahead else -3.0, 0.0, 0.0]), mode="to" if ahead else "fro")


class Flaps:
    """The planner cannot decide."""

    def begin(self, site: Site) -> None:
        site.planner.fault = "flaps"

    def is_felt(self, site: Site) -> bool:
        return site.planner.felt == "flaps"

    def end(self, site: Site) -> None:
        site.planner.fault = ""


class _Saboteur:
    """Carries the injections out, and remembers which were felt."""

    def __init__(self, injections: tuple[Injection, ...], planners: dict[str, Flapping], ends_s: float | None) -> None:
        self._injections, self._planners, self._ends_s = injections, planners, ends_s
        self._sites: dict[str, Site] = {}
        self._pursuit_s: dict[str, float] = {}
        self._state = ["waiting"] * len(injections)
        self.felt = [False] * len(injections)

    def watch(self, fleet: VirtualFleet) -> None:
        if not self._sites:
            for name, one in fleet.vehicles.items():
                self._sites[name] = Site(fleet, one, self._planners[name], BreakableDisk(), [], [], [])
                self._planners[name].spend = fleet.spend
        now_s = fleet.clock.now_s()
        for name, one in fleet.vehicles.items():
            if one.loop.phase == "pursue":
                self._pursuit_s.setdefault(name, now_s)
        for index, injection in enumerate(self._injections):
            self._drive(index, injection, now_s)
        began_s = min(self._pursuit_s.values(), default=now_s)
        if self._ends_s is not None and now_s - began_s > self._ends_s:
            fleet.stop()

    def _drive(self, index: int, injection: Injection, now_s: float) -> None:
        site, began_s = self._sites[injection.vehicle], self._pursuit_s.get(injection.vehicle)
        due_s = now_s if injection.at_s is None else None if began_s is None else began_s + injection.at_s
        if self._state[index] == "waiting" and due_s is not None and now_s >= due_s:
            self._state[index] = "on"
            injection.effect.begin(site)
        if self._state[index] == "on":
            self.felt[index] |= injection.effect.is_felt(site)
            if injection.at_s is not None and due_s is not None and now_s >= due_s + injection.lasts_s:
                self._state[index] = "over"
                injection.effect.end(site)


def fly(folder: Path, *injections: Injection, ends_s: float | None = None) -> Path:
    """Fly the demo mission into `folder`, to its end or `ends_s` after the start of the pursuit; every injection is felt."""
    folder.mkdir(parents=True)
    mission, profile = load_mission(MISSION), load_profile(PROFILE)
    planners = {one.name: Flapping(build_strategy(mission, one, profile, MISSION, SEED)) for one in mission.vehicles}
    saboteur = _Saboteur(injections, planners, ends_s)
    strategies: dict[str, Planner] = dict(planners)
    logging.disable(logging.CRITICAL)
    try:
        fly_virtual(MISSION, PROFILE, folder, seed=SEED, watch=saboteur.watch, strategies=strategies)
    finally:
        logging.disable(logging.NOTSET)
    assert all(saboteur.felt), f"not felt: {[one for one, felt in zip(injections, saboteur.felt, strict=True) if not felt]}"
    (folder / "mission.toml").write_bytes(MISSION.read_bytes())
    (folder / "profile.toml").write_bytes(PROFILE.read_bytes())
    return folder


def findings_of(folder: Path) -> tuple[Finding, ...]:
    """Everything that is found on the run in `folder`."""
    return examine_run(load_run([folder]), ANALYSERS)


def serious(findings: tuple[Finding, ...], analyser: str, vehicle: str = "") -> list[Finding]:
    """Warnings and failures of one analyser, on one vehicle or any."""
    return [
        one for one in findings if one.severity >= Severity.WARNING and one.analyser == analyser and vehicle in ("", one.vehicle)
    ]


Change = Callable[[dict[str, Any]], dict[str, Any] | None]


def changed(run: Path, folder: Path, changes: dict[tuple[str, str], Change], metadata: Change | None = None) -> Path:
    """A copy of `run` in `folder` with `changes` made to messages by (vehicle, topic); None leaves a message out."""
    folder.mkdir(parents=True)
    for path in run.iterdir():
        if path.suffix == ".mcap":
            own = {topic: change for (vehicle, topic), change in changes.items() if vehicle == path.stem}
            _copy(path, folder / path.name, own, metadata)
        elif path.suffix == ".toml":
            (folder / path.name).write_bytes(path.read_bytes())
    return folder


def _copy(source: Path, target: Path, changes: dict[str, Change], metadata: Change | None) -> None:
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, tuple[int, str]] = {}
    with target.open("xb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(profile=FILE_PROFILE)
        for record in Scan(source):
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
            elif isinstance(record, Channel) and record.id not in channels:
                new = writer.register_channel(record.topic, record.message_encoding, schemas[record.schema_id])
                channels[record.id] = (new, record.topic)
            elif isinstance(record, Message):
                channel, topic = channels[record.channel_id]
                data: bytes | None = record.data
                if topic in changes:
                    content = changes[topic](orjson.loads(record.data))
                    data = None if content is None else orjson.dumps(content)
                if data is not None:
                    writer.add_message(channel, record.log_time, data, record.publish_time)
            elif isinstance(record, Metadata):
                kept = record.metadata if metadata is None or record.name == "run" else metadata(record.metadata)
                if kept is not None:
                    writer.add_metadata(record.name, kept)
        writer.finish()  # type: ignore[no-untyped-call]
