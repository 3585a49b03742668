"""Sits in the simulation: injects the faults of a plan when their moment comes, and keeps what the invariants need."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_campaign.broken_disk import BreakableDisk
from flightapp.sim.fault_campaign.effects import BreakablePlanner, Effect, Site
from flightapp.sim.fault_campaign.kinds import KINDS
from flightapp.sim.fault_campaign.plan import Injection, Moment, Plan
from flightapp.sim.fault_campaign.trace import Flags, InjectionReport
from flightapp.sim.virtual.event_loop import START_S
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle

STEPS_A_SAMPLE = 4
TERMINAL_M = 6.0
BESIDE_M = 1.5
MOVING_M_S = 0.5
WAY_HOME = ("return", "land")


@dataclass(slots=True)
class _Pending:
    """One injection on its way. Times since the start of the simulation."""

    injection: Injection
    effect: Effect
    due_s: float | None = None
    began_s: float | None = None
    felt_s: float | None = None
    ended: bool = False
    watched: bool = True


class Observer:
    """Called every step of the simulation."""

    def __init__(self, plan: Plan, planners: dict[str, BreakablePlanner], disks: dict[str, BreakableDisk]) -> None:
        self._planners, self._disks = planners, disks
        self._pending = [_Pending(one, KINDS[one.kind].make(one)) for one in plan.injections]
        self.sites: dict[str, Site] = {}
        self.samples: dict[str, list[tuple[float, ...]]] = {}
        self._steps = 0

    def watch(self, fleet: VirtualFleet) -> None:
        now_s = fleet.clock.now_s() - START_S
        if not self.sites:
            self._begin(fleet)
        for site in self.sites.values():
            site.now_s = now_s
        for pending in self._pending:
            self._drive(pending, self.sites[pending.injection.vehicle], now_s)
        if self._steps % STEPS_A_SAMPLE == 0:
            for name, one in fleet.vehicles.items():
                self.samples[name].append(_sample(now_s, one))
        self._steps += 1

    def reports(self) -> tuple[InjectionReport, ...]:
        return tuple(
            InjectionReport(
                pending.injection.kind,
                pending.injection.vehicle,
                pending.began_s,
                pending.felt_s,
                KINDS[pending.injection.kind].excuses,
            )
            for pending in self._pending
        )

    def _begin(self, fleet: VirtualFleet) -> None:
        for name, one in fleet.vehicles.items():
            self.sites[name] = Site(fleet, one, self._planners[name], self._disks[name], [], [], [])
            self.samples[name] = []
            self._planners[name].spend = fleet.spend

    @staticmethod
    def _drive(pending: _Pending, site: Site, now_s: float) -> None:
        """Begin and end one injection, and notice when it is felt."""
        injection = pending.injection
        if pending.due_s is None and _has_come(injection.moment, site):
            pending.due_s = now_s + injection.delay_s
        if pending.began_s is None:
            if pending.due_s is None or now_s < pending.due_s:
                return
            pending.began_s = now_s
            pending.effect.begin(site)
        ends_s = math.inf if injection.duration_s is None else pending.began_s + injection.duration_s
        if not pending.ended and now_s >= ends_s:
            pending.ended = pending.watched = True
            pending.effect.end(site)
        if pending.watched and pending.effect.is_felt(site):
            pending.watched = False
            pending.felt_s = now_s if pending.felt_s is None else pending.felt_s


def _has_come(moment: Moment, site: Site) -> bool:
    one, phase = site.one, site.one.loop.phase
    if moment is Moment.START:
        return True
    if moment is Moment.TAKEOFF:
        return phase == "takeoff"
    if moment is Moment.WAY_HOME:
        return phase in WAY_HOME
    if phase != "pursue":
        return False
    if moment is Moment.TERMINAL:
        return _to_evader_m(site) < TERMINAL_M
    if moment is Moment.OBSTACLE:
        north, east, down = one.station.core.vehicle.position_ned_m
        moves = math.hypot(*one.station.core.vehicle.velocity_ned_m_s) > MOVING_M_S
        return moves and site.fleet.world.signed_distance_m(north, east, down) < BESIDE_M
    return True


def _to_evader_m(site: Site) -> float:
    """Distance of the nearest pursuer to the evader."""
    fleet = site.fleet.vehicles.values()
    evaders = [one.station.core.vehicle.position_ned_m for one in fleet if one.vehicle.role == "evader"]
    pursuers = [one.station.core.vehicle.position_ned_m for one in fleet if one.vehicle.role == "pursuer"]
    return min((math.dist(one, other) for one in evaders for other in pursuers), default=math.inf)


def _sample(now_s: float, one: VirtualVehicle) -> tuple[float, ...]:
    """Time, true position and velocity, armed, on the ground."""
    core = one.station.core
    return (now_s, *core.vehicle.position_ned_m, *core.vehicle.velocity_ned_m_s, core.armed, core.vehicle.on_ground)


def is_piloted(site: Site) -> bool:
    """A person flies the vehicle."""
    return bool(site.takeovers) and site.one.station.core.mode in (Mode.POSCTL, Mode.ALTCTL)


def columns(samples: list[tuple[float, ...]]) -> tuple[Array, Flags, Flags]:
    """States (n, 7), armed (n,), on the ground (n,)."""
    table = np.array(samples, dtype=np.float64).reshape(-1, 9)
    return table[:, :7], table[:, 7].astype(bool), table[:, 8].astype(bool)
