"""How the mission moves on: its phases, and its waits, after each of which the failsafes are looked at."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from flightapp.core.errors import FlightError
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.failsafe_watch import FailsafeWatch
from flightapp.runtime.rooms import Rooms

P = ParamSpec("P")
R = TypeVar("R")
POLL_PERIOD_S = 0.02
NEWS_TIMEOUT_S = 3.0
"""How long a heartbeat that tells the present state is waited for; they come once a second."""
LINK_GIVE_UP_S = 5.0
"""Silence of a lost link after which the process ends, so that its setpoints end and the autopilot's failsafe acts."""


class Pace:
    """Every wait may end in an `InterruptedMission`; the control loop runs meanwhile."""

    def __init__(self, rooms: Rooms, loop: ControlLoop, failsafes: FailsafeWatch) -> None:
        self._rooms = rooms
        self._loop = loop
        self._failsafes = failsafes

    def enter(self, phase: str, reason: str = "") -> None:
        """From now on the mission is in `phase`: recorded, and told to the team."""
        self._loop.phase = phase
        self._rooms.journal.phase(phase, reason, self._loop.outcome)

    async def tick(self, period_s: float = POLL_PERIOD_S) -> None:
        """Let the control loop run, then look whether something ends the mission."""
        await asyncio.sleep(period_s)
        self._failsafes.look()

    async def until(self, condition: Callable[[], bool], timeout_s: float, failure: str) -> None:
        """Wait for `condition`; FlightError with `failure` after `timeout_s`."""
        deadline_s = self._rooms.clock.now_s() + timeout_s
        while not condition():
            if self._rooms.clock.now_s() > deadline_s:
                raise FlightError(f"{failure} (waited {timeout_s:g} s)")
            await self.tick()

    async def computed(self, function: Callable[P, R], *given: P.args, **named: P.kwargs) -> R:
        """What may take longer than the deadman waits, in a thread: the vehicle goes on under the guards, and failsafes count."""
        computing = asyncio.create_task(asyncio.to_thread(function, *given, **named))
        while not computing.done():
            await self.tick()
        return computing.result()

    async def news(self) -> None:
        """Wait for a heartbeat and judge it. On a lost link none comes: then end, so that the setpoints end too."""
        rooms = self._rooms
        asked_s = rooms.clock.now_s()
        while rooms.autopilot.status().heartbeat_s <= asked_s:
            if rooms.clock.now_s() - rooms.autopilot.status().heartbeat_s > NEWS_TIMEOUT_S + LINK_GIVE_UP_S:
                raise FlightError(f"autopilot link lost: no heartbeat for {NEWS_TIMEOUT_S + LINK_GIVE_UP_S:g} s")
            await self.tick()
