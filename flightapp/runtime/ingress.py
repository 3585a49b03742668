"""Ingress: from above the start by a planned way past known obstacles to the station where the pursuit begins."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, VehicleState
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.failsafe_conditions import TARGET_AGE_MAX_S
from flightapp.runtime.interruption import InterruptedMission, Next
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.pace import Pace
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.way_planner import PlannedWay, WayPlanner

WAYS_TRIED = 3
LOOK_PERIOD_S = 0.2
BRAKE_TIMEOUT_S = 4.0


class Ingress:
    """The phase `ingress` of one vehicle that has a station; under all guards, and open to every failsafe and command."""

    def __init__(self, rooms: Rooms, loop: ControlLoop, pace: Pace) -> None:
        mission, vehicle = rooms.mission, rooms.vehicle
        assert vehicle.station is not None
        self._rooms, self._loop, self._pace = rooms, loop, pace
        self._ways = WayPlanner(rooms)
        self._down_m = -mission.height_of(vehicle)
        self._station = np.array((vehicle.station.north_m, vehicle.station.east_m, self._down_m))

    async def fly(self) -> bool:
        """To the station; True where the pursuit begins on the way there. InterruptedMission where the vehicle is held up."""
        self._pace.enter("ingress")
        for attempt in range(WAYS_TRIED):
            own = self._own()
            way = await self._planned(own.position_ned_m, attempt)
            self._rooms.journal.way(way)
            if way.trajectory is None:
                raise InterruptedMission(Next.RETURN, Outcome.FAULT, way.text)
            follower = self._ways.follower(way.trajectory)
            self._loop.follow(follower, yields=True)
            looked_s = -math.inf
            while not (follower.arrived or follower.failure):
                await self._pace.tick()
                now_s = self._rooms.clock.now_s()
                if now_s - looked_s >= LOOK_PERIOD_S:
                    looked_s = now_s
                    if reason := self._ends_early():
                        self._rooms.journal.event("info", "ingress", f"ends on the way: {reason}")
                        self._loop.hover_here(at_mission_height=True)
                        return True
            if follower.arrived:
                self._loop.hover_here(at_mission_height=True)
                return False
            self._rooms.journal.event("warning", "ingress", f"held up on the ingress: {follower.failure}")
            await self._brake()
        raise InterruptedMission(Next.RETURN, Outcome.FAULT, f"held up on the ingress {WAYS_TRIED} times")

    async def _planned(self, start: Array, attempt: int) -> PlannedWay:
        return await self._pace.computed(self._ways.plan, "ingress", start, self._station, self._loop.obstacles, attempt)

    def _ends_early(self) -> str:
        """Why the pursuit begins now; empty where it does not, or while something known lies between here and that height."""
        reason = self._evader_near() or self._team_pursues()
        if not reason or self._loop.held:
            return ""
        here = self._own().position_ned_m
        below = np.array((here[0], here[1], self._down_m))
        return reason if self._ways.is_clear(self._loop.obstacles, here, below) else ""

    def _evader_near(self) -> str:
        near_m, target = self._rooms.mission.ingress_handover_m, self._loop.target
        if self._rooms.vehicle.role != "pursuer" or target is None or target.age_s > TARGET_AGE_MAX_S:
            return ""
        distance_m = math.dist(self._own().position_ned_m[:2], target.position_ned_m[:2])
        return f"the evader is {distance_m:.0f} m away" if distance_m < near_m else ""

    def _team_pursues(self) -> str:
        states = [(name, peer.state) for name, peer in self._rooms.team.peers.items()]
        pursuing = [name for name, state in states if state is not None and state.phase == "pursue"]
        return f"{pursuing[0]} pursues already" if pursuing else ""

    def _own(self) -> VehicleState:
        motion = self._rooms.autopilot.motion()
        assert motion is not None, "nobody takes off without"
        return motion.state

    async def _brake(self) -> None:
        self._loop.hover_here()
        give_up_s = self._rooms.clock.now_s() + BRAKE_TIMEOUT_S
        while not self._loop.is_hovering and self._rooms.clock.now_s() < give_up_s:
            await self._pace.tick()
