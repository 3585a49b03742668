"""How each fault is done to a simulated vehicle, and how it is known that it was felt."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from flightapp.core.clock import monotonic_ns
from flightapp.core.types import Decision
from flightapp.fleet.messages.command import Acknowledgement, Command
from flightapp.planning.api import Observation, Planner
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_campaign.broken_disk import BreakableDisk
from flightapp.sim.fault_campaign.trace import Takeover, Wish
from flightapp.sim.fault_script import ActiveFault, Fault, Target, Verb
from flightapp.sim.virtual.camera import CameraFault
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle

NOTICED_S = 120.0
"""Real time within which the recorder's thread finds out about its disk, on a busy machine."""


@dataclass(slots=True)
class Site:
    """Where a fault happens: one vehicle, and what is kept about it for the invariants."""

    fleet: VirtualFleet
    one: VirtualVehicle
    planner: BreakablePlanner
    disk: BreakableDisk
    takeovers: list[Takeover]
    wishes: list[Wish]
    clock_steps: list[tuple[int, int, int, float]]
    """(setpoints, packets, commands, seconds): the clock went wrong by these seconds after so many of each."""
    now_s: float = 0.0
    """Since the start of the simulation."""

    @property
    def is_alive(self) -> bool:
        """The vehicle process runs."""
        return not self.one.hung and bool(self.one.tasks) and not any(task.done() for task in self.one.tasks[:2])


class Effect(Protocol):
    """One fault under way. `begin` once, `is_felt` until true, `end` once where the fault ends."""

    def begin(self, site: Site) -> None: ...

    def is_felt(self, site: Site) -> bool: ...

    def end(self, site: Site) -> None: ...


class Scripted:
    """A fault of the mock autopilot, which ends it by itself."""

    def __init__(self, target: Target, verb: Verb, duration_s: float | None, fields: Mapping[str, float]) -> None:
        self._fault: dict[str, object] = {"target": target, "verb": verb, **fields}
        if duration_s is not None:
            self._fault["duration_s"] = duration_s
        self._active: ActiveFault | None = None

    def begin(self, site: Site) -> None:
        engine = site.one.faults
        engine.add(Fault.model_validate({**self._fault, "at_s": site.one.station.core.t_s}))
        self._active = engine.faults[-1]

    def is_felt(self, site: Site) -> bool:  # noqa: ARG002
        return self._active is not None and self._active.felt_count > 0

    def end(self, site: Site) -> None:
        pass


class Piloted:
    """A person takes `mode` by stick or switch, and lands the vehicle at the end."""

    def __init__(self, mode: Mode) -> None:
        self._mode = mode
        self._takeover: Takeover | None = None

    def begin(self, site: Site) -> None:
        core = site.one.station.core
        if core.armed and site.is_alive:
            self._takeover = Takeover(site.now_s)
            site.takeovers.append(self._takeover)
            core.pilot_takes(self._mode)

    def is_felt(self, site: Site) -> bool:
        if self._takeover is None:
            return False
        if self._takeover.heard_s is None and site.one.autopilot.status().flight_mode == self._mode.name:
            self._takeover.heard_s = site.now_s
        return self._takeover.heard_s is not None

    def end(self, site: Site) -> None:
        if site.one.station.core.armed:
            site.one.station.core.pilot_takes(Mode.LAND)


class Commanded:
    """An operator sends `action`, and `then` at the end."""

    def __init__(self, action: str, then: str = "") -> None:
        self._action, self._then = action, then
        self._answers: Callable[[], list[Acknowledgement]] | None = None
        self._at = 0

    def begin(self, site: Site) -> None:
        self._send(site, self._action)

    def is_felt(self, site: Site) -> bool:
        answers = [] if self._answers is None else self._answers()
        if not answers:
            return False
        site.wishes[self._at] = replace(site.wishes[self._at], answered_s=site.now_s, accepted=answers[0].accepted)
        return True

    def end(self, site: Site) -> None:
        if self._then:
            self._send(site, self._then)

    def _send(self, site: Site, action: str) -> None:
        name, now_s = site.one.name, site.fleet.clock.now_s()
        reachable = site.is_alive and name not in site.fleet.network.cut_off
        self._at = len(site.wishes)
        site.wishes.append(Wish(site.now_s, action, reachable, None, accepted=False))
        command = Command(action, f"{action}-{name}-{site.now_s:.3f}", now_s, "campaign")
        self._answers = site.fleet.network.command(site.fleet.mission.fleet, name, command)


class Killed:
    """SIGKILL of the vehicle process."""

    def __init__(self) -> None:
        self._felt = False

    def begin(self, site: Site) -> None:
        self._felt = site.is_alive
        if self._felt:
            site.one.kill()

    def is_felt(self, site: Site) -> bool:  # noqa: ARG002
        return self._felt

    def end(self, site: Site) -> None:
        pass


class Hung:
    """The interpreter hangs until the deadman kills it."""

    def begin(self, site: Site) -> None:
        if site.is_alive:
            site.one.hang()

    def is_felt(self, site: Site) -> bool:
        return site.one.hung

    def end(self, site: Site) -> None:
        pass


class Planning:
    """The planner raises, gives no number, or takes long."""

    def __init__(self, how: str) -> None:
        self._how = how

    def begin(self, site: Site) -> None:
        site.planner.fault = self._how

    def is_felt(self, site: Site) -> bool:
        return site.planner.felt == self._how

    def end(self, site: Site) -> None:
        site.planner.fault = ""


class Filmed:
    """The camera is gone, blind, or its thread raises."""

    def __init__(self, fault: CameraFault) -> None:
        self._fault = fault

    def begin(self, site: Site) -> None:
        if site.one.camera is not None and site.is_alive:
            site.one.camera.fault = self._fault

    def is_felt(self, site: Site) -> bool:
        return site.one.camera is not None and site.one.camera.fault == self._fault

    def end(self, site: Site) -> None:
        if site.one.camera is not None:
            site.one.camera.fault = ""


class CutOff:
    """Nothing goes between this vehicle and the others."""

    def begin(self, site: Site) -> None:
        site.fleet.network.cut_off.add(site.one.name)

    def is_felt(self, site: Site) -> bool:
        return site.is_alive

    def end(self, site: Site) -> None:
        site.fleet.network.cut_off.discard(site.one.name)


class WrongClock:
    """The vehicle computer's clock is wrong from the start; in flight fleet time is monotonic and cannot jump."""

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s

    def begin(self, site: Site) -> None:
        autopilot = site.one.autopilot
        site.clock_steps.append((len(autopilot.sent), len(autopilot.transmitted_s), len(autopilot.commands), self._step_s))
        site.one.clock.offset_s += self._step_s

    def is_felt(self, site: Site) -> bool:
        return site.is_alive

    def end(self, site: Site) -> None:
        pass


class FullDisk:
    """Nothing more can be written."""

    def begin(self, site: Site) -> None:
        site.disk.is_full = True
        # The recorder's thread lives in real time: it is waited for, so that a seed repeats.
        give_up_ns = monotonic_ns() + round(NOTICED_S * 1e9)
        while site.one.recorder.error is None and monotonic_ns() < give_up_ns:
            time.sleep(0.01)

    def is_felt(self, site: Site) -> bool:
        return site.one.recorder.error is not None

    def end(self, site: Site) -> None:
        pass


class BreakablePlanner:
    """A strategy that fails on demand: raises, decides nothing finite, or computes for `long_s`."""

    long_s = 0.08

    def __init__(self, planner: Planner) -> None:
        self._planner = planner
        self.fault = ""
        self.felt = ""
        self.spend: Callable[[float], None] | None = None

    def step(self, observation: Observation) -> Decision:
        decision = self._planner.step(observation)
        if not self.fault:
            return decision
        self.felt = self.fault
        if self.fault == "raises":
            raise RuntimeError("the planner is broken by the campaign")
        if self.fault == "no number":
            return replace(decision, velocity_ned_m_s=np.full(3, math.nan))
        if self.spend is not None:
            self.spend(self.long_s)
        return decision

    def reset(self, seed: int | None = None) -> None:
        self._planner.reset(seed)
