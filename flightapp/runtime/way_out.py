"""Ways out of traps: where the strategy goes nowhere, a planned way is flown until the strategy can go on.

The strategy is asked all the time, so that capture and recovery are seen; its decisions are not flown meanwhile.
"""

from __future__ import annotations

import asyncio
import math

import numpy as np

from flightapp.core.types import Array, VehicleState
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.failsafe_conditions import TARGET_AGE_MAX_S
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.trap_watch import TrapWatch
from flightapp.runtime.way_follower import WayFollower
from flightapp.runtime.way_planner import PlannedWay, WayPlanner

LOOK_PERIOD_S = 0.2
BRAKE_TIMEOUT_S = 4.0
PATIENCE_S = 10.0
"""After a way was not found the strategy is left alone for so long."""


class WayOut:
    """`poll` after every wait of the pursuit. Nothing here waits."""

    def __init__(self, rooms: Rooms, loop: ControlLoop) -> None:
        self._rooms, self._loop = rooms, loop
        self._ways = WayPlanner(rooms)
        self._down_m = -rooms.mission.height_of(rooms.vehicle)
        self._watch = TrapWatch()
        self._looked_s = self._patient_until_s = -math.inf
        self._braking_s: float | None = None
        self._planning: asyncio.Task[PlannedWay] | None = None
        self._follower: WayFollower | None = None
        self._found = 0

    def poll(self) -> None:
        """Look for a trap, or for the end of the way out of it."""
        now_s, loop = self._rooms.clock.now_s(), self._loop
        motion = self._rooms.autopilot.motion()
        if motion is None or now_s - self._looked_s < LOOK_PERIOD_S:
            return
        self._looked_s = now_s
        if self._planning is not None:
            if self._planning.done():
                self._take(self._planning.result(), now_s)
        elif self._follower is not None:
            self._look_ahead(motion.state, self._follower)
        elif loop.held or now_s < self._patient_until_s:
            self._watch.reset()
            self._braking_s = None
            loop.end_detour()
        elif self._braking_s is not None:
            if loop.is_standing or now_s - self._braking_s > BRAKE_TIMEOUT_S:
                self._braking_s = None
                self._plan(motion.state)
        else:
            self._look_for_trap(motion.state, now_s)

    def _look_for_trap(self, own: VehicleState, now_s: float) -> None:
        target = self._target()
        if target is None or self._loop.decision is None:
            self._watch.reset()
            return
        mode = self._loop.decision.mode
        reason = self._watch.trapped(now_s, own.position_ned_m, target, mode, lambda: not self._is_free(own, target))
        if reason:
            self._rooms.journal.event("warning", "way_out", f"trapped: {reason}")
            self._braking_s = now_s
            self._loop.detour(None)

    def _plan(self, own: VehicleState) -> None:
        target = self._target()
        if target is None:
            self._give_back("the evader is lost")
            return
        goal = np.array((target[0], target[1], self._down_m))
        planned = asyncio.to_thread(self._ways.plan, "way out", own.position_ned_m, goal, self._loop.obstacles, self._found)
        self._planning = asyncio.create_task(planned)

    def _take(self, way: PlannedWay, now_s: float) -> None:
        self._planning = None
        self._found += 1
        self._rooms.journal.way(way)
        if way.trajectory is None:
            self._patient_until_s = now_s + PATIENCE_S
            self._give_back("there is no way out")
            return
        self._follower = self._ways.follower(way.trajectory)
        self._loop.detour(self._follower)

    def _look_ahead(self, own: VehicleState, follower: WayFollower) -> None:
        target = self._target()
        if follower.failure:
            self._give_back(f"held up: {follower.failure}")
        elif follower.arrived:
            self._give_back("the way out is flown")
        elif target is not None and not self._loop.held and self._is_free(own, target):
            self._give_back("the way to the evader is free")

    def _give_back(self, reason: str) -> None:
        self._follower = None
        self._watch.reset()
        self._loop.end_detour()
        self._rooms.journal.event("info", "way_out", f"the strategy flies on: {reason}")

    def _target(self) -> Array | None:
        """Where the evader is, (3,); None without news of it."""
        target = self._loop.target
        return None if target is None or target.age_s > TARGET_AGE_MAX_S else target.position_ned_m

    def _is_free(self, own: VehicleState, target: Array) -> bool:
        """Whether the strategy can fly to the target at mission height: at once down to it, there, or anywhere between."""
        here, seen = own.position_ned_m, self._loop.obstacles
        level = np.array((here[0], here[1], self._down_m))
        there = np.array((target[0], target[1], self._down_m))
        above = np.array((target[0], target[1], here[2]))
        return self._ways.is_clear(seen, here, level, there, here, above)
