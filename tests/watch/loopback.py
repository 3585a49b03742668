"""A vehicle that shares its state, tells the time, leads and answers commands over real Zenoh.

In the test's own event loop, or as a process that can be killed: NAME ENDPOINT AHEAD_S.
"""

from __future__ import annotations

import asyncio
import sys

import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.clock_watch import ClockWatch
from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.messages.command import Command
from flightapp.fleet.messages.election import ELECTION
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team
from tests.watch.scenes import DIGEST, MISSION

PERIOD_S = 0.05


class AheadClock:
    """A clock that is wrong by `ahead_s`."""

    def __init__(self, ahead_s: float) -> None:
        self._clock, self._ahead_s = SystemClock(), ahead_s

    def now_s(self) -> float:
        return self._clock.now_s() + self._ahead_s


class LoopbackVehicle:
    """`obeyed`: the actions of the commands that it was given."""

    def __init__(self, session: zenoh.Session, name: str, ahead_s: float = 0.0) -> None:
        self._clock = AheadClock(ahead_s)
        self._team = Team(session, MISSION.fleet, name, [], lambda *_: None)
        self._clocks = ClockWatch(self._team.post, self._clock)
        self._beacons = self._team.post.outlet(ELECTION)
        self.obeyed: list[str] = []

    async def fly(self) -> None:
        while True:
            self.tick()
            await asyncio.sleep(PERIOD_S)

    def tick(self) -> None:
        now_s = self._clock.now_s()
        state = State(now_s, (20.0, 5.0, -6.5), (3.0, 4.0, 0.0), 0.0, airborne=True, phase="pursue", outcome=None)
        intent = Intent("pursuer", DIGEST, 1, "coarse", None, None, 12.0, 3.0, None, ("separation",))
        self._team.publish(state, intent, now_s)
        self._beacons.put(Beacon(now_s, 4, Role.LEADER), now_s)
        self._team.take_commands(now_s, self._accept)

    def _accept(self, command: Command) -> tuple[bool, str]:
        self.obeyed.append(command.action)
        return (False, "not possible in phase takeoff") if command.action == "resume" else (True, f"obeys {command.action}")


if __name__ == "__main__":
    own_name, endpoint, ahead = sys.argv[1:]
    asyncio.run(LoopbackVehicle(zenoh.open(zenoh_config([endpoint], [])), own_name, float(ahead)).fly())
