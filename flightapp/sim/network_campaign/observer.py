"""Watches a virtual fleet over bad links: splits and heals it, measures ages, and holds what must always hold against it."""

from __future__ import annotations

import math
from collections import defaultdict
from itertools import combinations

import numpy as np

from flightapp.safety.parameters import SafetyParameters
from flightapp.sim.link_shaper import LinkShaper
from flightapp.sim.network_campaign.conditions import PartitionKind, side_of
from flightapp.sim.virtual.figures import PURSUIT
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle

SPLIT_AFTER_S = 3.0
"""Since the pursuit began: the pursuers are on their way."""
SPLIT_FOR_S = 6.0
AGE_PERIOD_S = 0.05
SEEN_OUT_S = 2.0
"""Flown on after the pursuit has ended: what follows from a capture that not everybody knows of shows by then."""
SLACK_M = 0.05
"""The guard steers by estimates; what must hold is held against true places."""


class NetworkObserver:
    """Give `watch` to `fly_virtual`; ages are in seconds, of the newest state that each vehicle has of each other one."""

    def __init__(self, shaper: LinkShaper, partition: PartitionKind, safety: SafetyParameters) -> None:
        self._shaper, self._partition, self._safety = shaper, partition, safety
        self.began_s = self.ended_s = math.inf
        self.separation_m = math.inf
        self.ages_s: list[float] = []
        self.leader_changes = 0
        self.split_felt = False
        self.broken: dict[str, str] = {}
        """First finding of each kind."""
        self._leader: str | None = None
        self._leaders: defaultdict[int, set[str]] = defaultdict(set)
        self._ages_due_s = -math.inf

    def watch(self, fleet: VirtualFleet) -> None:
        """After every step."""
        now_s = fleet.clock.now_s()
        pursuers = [one for one in fleet.vehicles.values() if one.vehicle.role == "pursuer"]
        fleet.network.shaper = self._shaper
        pursuing = any(one.loop.phase == PURSUIT for one in pursuers)
        if pursuing and self.began_s > now_s:
            self.began_s = now_s
        elif not pursuing and self.began_s < now_s < self.ended_s:
            self.ended_s = now_s
        if pursuing:
            self._note_leader(pursuers, now_s)
            self._note_ages(fleet, now_s)
        self._split_and_heal(fleet, now_s)
        self._judge(fleet, pursuers, now_s)
        if now_s >= self.ended_s + SEEN_OUT_S:
            fleet.stop()

    def _split_and_heal(self, fleet: VirtualFleet, now_s: float) -> None:
        since_s = now_s - self.began_s
        if SPLIT_AFTER_S <= since_s < SPLIT_AFTER_S + SPLIT_FOR_S:
            names = {
                role: [one.name for one in fleet.vehicles.values() if one.vehicle.role == role] for role in ("pursuer", "evader")
            }
            self._shaper.split(side_of(self._partition, names["pursuer"], names["evader"]))
            self.split_felt |= any(age_s > 1.0 for age_s in self.ages_s[-(len(fleet.vehicles) ** 2) :])
        else:
            self._shaper.heal()

    def _note_leader(self, pursuers: list[VirtualVehicle], now_s: float) -> None:
        for one in pursuers:
            if one.loop.leadership.is_leader(one.rooms.clock.now_s()):
                self._leaders[one.loop.leadership.term].add(one.name)
                if one.name != self._leader:
                    self.leader_changes += self._leader is not None
                    self._leader = one.name
        for term, names in self._leaders.items():
            if len(names) > 1:
                self._find("two leaders", f"{' and '.join(sorted(names))} both led in term {term}", now_s)

    def _note_ages(self, fleet: VirtualFleet, now_s: float) -> None:
        if now_s < self._ages_due_s:
            return
        self._ages_due_s = now_s + AGE_PERIOD_S - 1e-6
        for one in fleet.vehicles.values():
            if one.loop.phase == PURSUIT:
                states = [peer.state for peer in one.rooms.team.peers.values()]
                own_s = one.rooms.clock.now_s()
                self.ages_s += [own_s - state.t_s for state in states if state is not None and state.phase != "done"]

    def _judge(self, fleet: VirtualFleet, pursuers: list[VirtualVehicle], now_s: float) -> None:
        """Bodies never touch; pursuers that are beside one another keep the separation once the pursuit has begun."""
        flying = [one for one in fleet.vehicles.values() if one.is_flying]
        for one in flying:
            if fleet.world.signed_distance_m(*one.position_ned_m.tolist()) < one.rooms.limits.body_radius_m:
                self._find("contact", f"{one.name} touches an obstacle", now_s)
        for one, other in combinations(flying, 2):
            apart = one.position_ned_m - other.position_ned_m
            if float(np.linalg.norm(apart)) < one.rooms.limits.body_radius_m + other.rooms.limits.body_radius_m:
                self._find("contact", f"{one.name} touches {other.name}", now_s)
            if one in pursuers and other in pursuers and abs(apart[2]) < self._safety.separation_height_m:
                self._note_separation(one, other, math.hypot(*apart[:2].tolist()), now_s)

    def _note_separation(self, one: VirtualVehicle, other: VirtualVehicle, apart_m: float, now_s: float) -> None:
        if now_s < self.began_s:
            return
        self.separation_m = min(self.separation_m, apart_m)
        if apart_m < self._safety.separation_min_m - SLACK_M:
            self._find("separation", f"{one.name} and {other.name} are {apart_m:.2f} m apart", now_s)

    def _find(self, kind: str, text: str, now_s: float) -> None:
        self.broken.setdefault(kind, f"{kind}: {text}, {now_s - self.began_s:.1f} s into the pursuit")
