"""A vehicle that shares its state and tells the time, as a process that can be frozen and killed: NAME OTHER LISTEN CONNECT."""

import asyncio
import sys

import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.clock_watch import ClockWatch
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State
from flightapp.fleet.roster import Roster
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team

PERIOD_S = 0.05


class AheadClock:
    """A clock that is wrong by `ahead_s`."""

    def __init__(self, ahead_s: float) -> None:
        self._clock, self._ahead_s = SystemClock(), ahead_s

    def now_s(self) -> float:
        return self._clock.now_s() + self._ahead_s


async def share(name: str, other: str, listen: str, connect: str, ahead_s: float) -> None:
    clock = AheadClock(ahead_s)
    team = Team(zenoh.open(zenoh_config([listen], [connect])), "f", name, [other], lambda *_: None)
    watch, roster = ClockWatch(team.post, clock), Roster(team.post)
    asking = asyncio.create_task(watch.run())
    intent = Intent("pursuer", "0123456789ab", 2, "coarse", None, None, None, None, None, ())
    while not asking.done():
        now_s = clock.now_s()
        watch.poll(now_s)
        roster.poll()
        team.poll(now_s)
        state = State(now_s, (1.0, 2.0, -5.0), (0.0, 0.0, 0.0), 0.0, airborne=True, phase="pursue", outcome=None)
        team.publish(state, intent, now_s)
        await asyncio.sleep(PERIOD_S)


if __name__ == "__main__":
    asyncio.run(share(*sys.argv[1:5], float(sys.argv[5])))
