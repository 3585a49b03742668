"""Bringing the vehicle down: brake, return or land, and insist, whatever happens on the way; or leave it to who has control."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING

from flightapp.core.errors import FlightError
from flightapp.runtime.authority import Authority
from flightapp.runtime.control_loop import ControlLoop, Guidance
from flightapp.runtime.failsafe_conditions import is_own_state_stale
from flightapp.runtime.failsafe_watch import FailsafeWatch
from flightapp.runtime.interruption import DOING, InterruptedMission, Next
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.pace import Pace
from flightapp.runtime.rooms import Rooms

if TYPE_CHECKING:
    from flightapp.runtime.way_home import WayHome  # compiled: loaded only where it is flown

RETURN_TIMEOUT_S = 240.0
WAYS_TRIED = 3
BRAKE_TIMEOUT_S = 4.0
RETRY_PERIOD_S = 2.5
GIVE_UP_LANDING_S = 20.0
GIVE_UP_TERMINATION_S = 5.0
WATCH_GIVE_UP_S = 30.0


class BringingDown:
    """Ends one flight. A failsafe that is more severe than what is being done replaces it on the way."""

    def __init__(self, rooms: Rooms, loop: ControlLoop, authority: Authority, failsafes: FailsafeWatch, pace: Pace) -> None:
        self._rooms = rooms
        self._loop = loop
        self._authority = authority
        self._failsafes = failsafes
        self._pace = pace
        self._stop_watching = False
        self._way_home = _way_home(rooms)

    def stop_watching(self) -> None:
        """End the record of a vehicle that somebody else flies."""
        self._stop_watching = True

    async def run(self, action: Next, outcome: Outcome, reason: str) -> Outcome:
        """Until the vehicle is disarmed; FlightError where this app cannot bring it down."""
        while True:
            try:
                await self._execute(action, outcome, reason)
                self._pace.enter("done", "disarmed" if not self._stop_watching else "no longer watched")
                return outcome
            except InterruptedMission as change:
                if change.outcome is Outcome.FAULT:
                    outcome = Outcome.FAULT
                action, reason = change.action, change.reason
                self._rooms.journal.event("warning", "interrupted", reason, action=action.value)
            except FlightError as error:
                self._loop.outcome = Outcome.FAULT.value
                self._rooms.journal.event("error", "fault", str(error))
                self._pace.enter("done", "the app cannot bring the vehicle down: the autopilot's failsafe must")
                raise

    async def _execute(self, action: Next, outcome: Outcome, reason: str) -> None:
        rooms, loop = self._rooms, self._loop
        loop.outcome = outcome.value
        self._failsafes.doing = DOING[action]
        if action is Next.RELEASE:
            loop.guidance = Guidance.NONE
            self._pace.enter("released", reason)
            await self._watch_until_disarmed()
            return
        self._pace.enter(action.value, reason)
        if action is Next.TERMINATE:
            loop.guidance = Guidance.NONE
            if await self._terminate():
                return
        if loop.guidance is not Guidance.NONE and loop.failure is None:
            await self._brake()
        if action is Next.RETURN and not await self._landing_follows():
            await self._insist(rooms.autopilot.return_to_launch, "RETURN_TO_LAUNCH", "LAND")
        elif rooms.autopilot.status().landed_state == "ON_GROUND" and await self._disarmed_on_the_ground():
            return
        else:
            await self._insist(rooms.autopilot.land, "LAND")
        loop.guidance = Guidance.NONE
        await self._pace.until(
            lambda: not rooms.autopilot.status().armed,
            RETURN_TIMEOUT_S,
            f"not on the ground {RETURN_TIMEOUT_S:g} s after '{action.value}'",
        )

    async def _landing_follows(self) -> bool:
        """Fly the planned way home, if the mission has one: True where the vehicle must land then, and not return any more.

        That is above its start, or where neither a way nor the autopilot's own return keeps clear of what is known.
        """
        loop, way_home, autopilot = self._loop, self._way_home, self._rooms.autopilot
        if way_home is None or loop.guidance is Guidance.NONE or loop.failure is not None:
            return False
        for attempt in range(WAYS_TRIED):
            motion = autopilot.motion()
            if motion is None or is_own_state_stale(self._rooms, self._rooms.clock.now_s()):
                return False
            way = await self._pace.computed(way_home.plan, motion.state, loop.obstacles, attempt)
            self._rooms.journal.way(way)
            if way.trajectory is None:
                free = await self._pace.computed(way_home.is_return_free, motion.state, loop.obstacles)
                self._rooms.journal.event("warning", "way_home", f"{'return' if free else 'landing'} instead")
                return not free
            follower = way_home.ways.follower(way.trajectory)
            loop.follow(follower)
            while not (follower.arrived or follower.failure):
                await self._pace.tick()
                if loop.guidance is not Guidance.WAY:
                    return False
            if follower.arrived:
                return True
            self._rooms.journal.event("warning", "way_home", f"held up on the way home: {follower.failure}")
            await self._brake()
        return True

    async def _disarmed_on_the_ground(self) -> bool:
        """Disarm a vehicle that stands; the autopilot refuses it to one that flies, whatever was reported."""
        try:
            await self._rooms.autopilot.disarm()
        except FlightError:
            return False
        return True

    async def _terminate(self) -> bool:
        """Ask for termination until the motors are off; False where the autopilot will not, and landing is all that is left."""
        rooms = self._rooms
        give_up_s = rooms.clock.now_s() + GIVE_UP_TERMINATION_S
        while rooms.clock.now_s() < give_up_s:
            try:
                await rooms.autopilot.terminate()
            except Exception as error:  # A refusal, or MAVSDK itself.
                rooms.journal.event("error", "command_failed", str(error))
            retry_s = rooms.clock.now_s() + RETRY_PERIOD_S
            while rooms.clock.now_s() < retry_s:
                if not rooms.autopilot.status().armed:
                    return True
                await self._pace.tick()
        rooms.journal.event("error", "safety", f"not terminated within {GIVE_UP_TERMINATION_S:g} s: landing instead")
        return False

    async def _watch_until_disarmed(self) -> None:
        """Somebody else flies: record until the vehicle is disarmed, or the link has been dead for long."""
        rooms = self._rooms
        while rooms.autopilot.status().armed and not self._stop_watching:
            if rooms.clock.now_s() - rooms.autopilot.status().heartbeat_s > WATCH_GIVE_UP_S:
                raise FlightError(f"no heartbeat of the autopilot for {WATCH_GIVE_UP_S:g} s after the app gave up control")
            await self._pace.tick()

    async def _brake(self) -> None:
        """Come to rest under the guards before the autopilot takes over: its own modes do not know the obstacles.

        A rest that cannot be seen, because no state of the vehicle comes, is not waited for.
        """
        clock = self._rooms.clock
        self._loop.hover_here()
        give_up_s = clock.now_s() + BRAKE_TIMEOUT_S
        while not (self._loop.is_hovering or is_own_state_stale(self._rooms, clock.now_s()) or clock.now_s() > give_up_s):
            await self._pace.tick()

    async def _insist(self, command: Callable[[], Awaitable[None]], *modes: str) -> None:
        """Command a mode until the autopilot reports it. Nothing is commanded before news of the present mode was judged."""
        rooms = self._rooms
        give_up_s = rooms.clock.now_s() + GIVE_UP_LANDING_S
        while True:
            await self._pace.news()
            if not rooms.autopilot.status().armed or rooms.autopilot.status().flight_mode in modes:
                return
            if rooms.clock.now_s() > give_up_s:
                raise FlightError(f"the autopilot did not change to {modes[0]} within {GIVE_UP_LANDING_S:g} s")
            try:
                await command()
            except Exception as error:  # A refusal, or MAVSDK itself: try again until it is time to give up.
                rooms.journal.event("error", "command_failed", str(error))
            else:
                self._authority.take(*modes)
            retry_s = rooms.clock.now_s() + RETRY_PERIOD_S
            while rooms.clock.now_s() < retry_s:
                if rooms.autopilot.status().flight_mode in modes or not rooms.autopilot.status().armed:
                    return
                await self._pace.tick()


def _way_home(rooms: Rooms) -> WayHome | None:
    """What plans the way home, where the mission wants that."""
    if rooms.mission.way_home != "planned":
        return None
    from flightapp.runtime.way_home import WayHome

    return WayHome(rooms)
