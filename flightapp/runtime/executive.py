"""The mission executive: preflight, arm, take off, ingress, wait for the team, pursue, return, land.

It reads like the mission it flies. Whatever ends the mission early is an `InterruptedMission` with the one action that
follows: the failsafes are looked at after every wait (`pace`, `failsafe_watch`), who has control is known to `authority`, and
`bringing_down` ends every flight. Heartbeats come once a second, so news of mode and arming is waited for before anything
rests on it.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Collection
from typing import TYPE_CHECKING

from flightapp.core.errors import FlightError
from flightapp.fleet.messages.command import Command
from flightapp.planning.plane import Point, crosses, planar, segments
from flightapp.runtime import operator_commands
from flightapp.runtime.authority import Authority
from flightapp.runtime.bringing_down import BringingDown
from flightapp.runtime.control_loop import ControlLoop, Guidance
from flightapp.runtime.failsafe_conditions import TARGET_AGE_MAX_S, is_own_state_stale
from flightapp.runtime.failsafe_watch import FailsafeWatch
from flightapp.runtime.ground_checks import pass_checklist
from flightapp.runtime.heartbeat import CLIMBING
from flightapp.runtime.interruption import InterruptedMission, Next
from flightapp.runtime.outcome import Outcome, outcome_of_team
from flightapp.runtime.pace import NEWS_TIMEOUT_S, POLL_PERIOD_S, Pace
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.team_readiness import missing_vehicles
from flightapp.safety.failsafe.table import Condition

if TYPE_CHECKING:
    from flightapp.runtime.ingress import Ingress  # compiled: loaded only where they are flown
    from flightapp.runtime.way_out import WayOut

TAKEOFF_TIMEOUT_S = 45.0
MODE_TIMEOUT_S = 5.0
SETPOINTS_BEFORE_OFFBOARD = 15
"""PX4 accepts OFFBOARD only on a running stream (> 2 Hz for more than half a second)."""
SHORT_HOLD_S = 3.0
STANDS_M_S = 0.3
"""Vertical speed of a vehicle in HOLD at most; one that is told to climb in HOLD has stuck telemetry."""
HEIGHT_REACHED_FRACTION = 0.9


class Executive:
    """Flies one mission on one vehicle. `attach` comes before everything else."""

    def __init__(self, rooms: Rooms, waived: Collection[str] = ()) -> None:
        self._rooms = rooms
        self._waived = waived
        self._arm_asked_s: float | None = None

    def attach(self, loop: ControlLoop) -> None:
        """The control loop that carries the mission out; it needs `on_command` to be made, and so comes later."""
        rooms = self._rooms
        self._loop = loop
        self._authority = Authority(rooms.autopilot, rooms.clock)
        loop.in_own_mode = lambda: self._authority.is_own_mode
        self._failsafes = FailsafeWatch(rooms, loop, self._authority)
        self._pace = Pace(rooms, loop, self._failsafes)
        self._bringing_down = BringingDown(rooms, loop, self._authority, self._failsafes, self._pace)
        self._ingress = _ingress(rooms, loop, self._pace)
        self._way_out = _way_out(rooms, loop)

    def request_landing(self, reason: str) -> None:
        """Land as soon as possible (termination signal). A vehicle that somebody else flies is only let go of."""
        if self._loop.phase == "released":
            self._bringing_down.stop_watching()
        else:
            self._failsafes.want(Condition.OPERATOR_LAND, reason)

    def on_command(self, command: Command) -> tuple[bool, str]:
        """Operator command -> (accepted, text)."""
        return operator_commands.obey(command, self._loop, self._failsafes)

    async def fly(self) -> Outcome:
        """The whole mission; FlightError only where the vehicle cannot be brought down by this app."""
        action, reason = Next.RETURN, "mission complete"
        try:
            await self._check_on_the_ground()
            await self._take_off()
            begins_early = self._ingress is not None and await self._ingress.fly()
            await self._wait_for_team(begins_early=begins_early)
            outcome = await self._pursue()
        except InterruptedMission as interruption:
            action, outcome, reason = interruption.action, interruption.outcome, interruption.reason
            self._rooms.journal.event("warning", "interrupted", reason, action=action.value, outcome=outcome.value)
        except Exception as error:  # Whatever broke, the vehicle must still come down.
            action, outcome, reason = Next.LAND, Outcome.FAULT, str(error) or type(error).__name__
            self._rooms.journal.event("error", "fault", reason, kind=type(error).__name__)
        self._failsafes.is_pursuing = False
        self._loop.outcome = outcome.value
        if await self._is_disarmed():
            self._pace.enter("done", reason)
            return outcome
        return await self._bringing_down.run(action, outcome, reason)

    async def _check_on_the_ground(self) -> None:
        rooms = self._rooms
        self._pace.enter("preflight")
        await pass_checklist(rooms, self._loop, self._pace, self._waived)
        height_m = rooms.mission.height_of(rooms.vehicle) - rooms.vehicle.start.ground_height_m
        return_height_m = rooms.mission.return_height_of(rooms.vehicle) - rooms.vehicle.start.ground_height_m
        await rooms.autopilot.set_heights(height_m, return_height_m)

    async def _take_off(self) -> None:
        rooms, loop, pace = self._rooms, self._loop, self._pace
        pace.enter("arm")
        self._failsafes.look()
        await pace.until(lambda: rooms.heartbeat.last == CLIMBING, MODE_TIMEOUT_S, "the deadman was not told of the climb")
        self._arm_asked_s = rooms.clock.now_s()
        await rooms.autopilot.arm()
        self._failsafes.look()
        pace.enter("takeoff")
        await rooms.autopilot.takeoff()
        self._authority.take("TAKEOFF", "HOLD")
        await self._climb()
        loop.hover_here()
        streaming = loop.setpoints_sent + SETPOINTS_BEFORE_OFFBOARD
        await pace.until(lambda: loop.setpoints_sent >= streaming, MODE_TIMEOUT_S, "no setpoints were sent")
        await pace.news()  # A pilot who has just taken over must not be overruled by what is commanded next.
        await rooms.autopilot.start_offboard()
        self._authority.take("OFFBOARD")
        await pace.until(lambda: rooms.autopilot.status().flight_mode == "OFFBOARD", MODE_TIMEOUT_S, "OFFBOARD was not reported")
        loop.in_offboard = True

    async def _climb(self) -> None:
        """Wait for the height. HOLD follows a finished take-off; a HOLD that stays below it was somebody's choice."""
        rooms = self._rooms
        ground = rooms.vehicle.start.ground_height_m
        wanted = ground + HEIGHT_REACHED_FRACTION * (rooms.mission.height_of(rooms.vehicle) - ground)
        deadline_s = rooms.clock.now_s() + TAKEOFF_TIMEOUT_S
        climbing_s = rooms.clock.now_s()
        while self._height_m() < wanted:
            now_s = rooms.clock.now_s()
            holds = self._authority.is_settled and rooms.autopilot.status().flight_mode == "HOLD"
            if not holds or is_own_state_stale(rooms, now_s) or not self._stands():
                climbing_s = now_s  # An old height, or one that is stuck, does not tell where the climb has ended.
            if now_s - climbing_s > SHORT_HOLD_S:
                raise self._failsafes.release("HOLD below the mission height: not this app's choice")
            if now_s > deadline_s:
                raise FlightError(f"take-off did not reach {wanted:.1f} m (waited {TAKEOFF_TIMEOUT_S:g} s)")
            await self._pace.tick()

    async def _wait_for_team(self, *, begins_early: bool) -> None:
        rooms = self._rooms
        self._pace.enter("ready")
        deadline_s = rooms.clock.now_s() + rooms.mission.start_timeout_s
        while missing := missing_vehicles(rooms, begins_early=begins_early):
            if rooms.clock.now_s() > deadline_s:
                raise FlightError(f"the team was not ready within {rooms.mission.start_timeout_s:g} s: {', '.join(missing)}")
            await self._pace.tick()

    async def _pursue(self) -> Outcome:
        rooms, loop = self._rooms, self._loop
        self._pace.enter("pursue")
        rooms.planner.reset()
        if rooms.tracker is not None:
            rooms.tracker.begin()
        loop.guidance = Guidance.PLANNER
        self._failsafes.is_pursuing = True
        started_s = rooms.clock.now_s()
        before = None
        edge = segments(rooms.boundary)
        while True:
            await self._pace.tick()
            if self._way_out is not None:
                self._way_out.poll()
            told = outcome_of_team(peer.state.outcome for peer in rooms.team.peers.values() if peer.state is not None)
            if told is not None:
                return self._end_pursuit(told, "told by the team")
            if (how := self._captured()) is not None:
                text, by = how
                return self._end_pursuit(Outcome.CAPTURED, text, by)
            position = self._evader_position()
            if position is not None and before is not None and crosses(before, position, edge):
                return self._end_pursuit(Outcome.ESCAPED, "the evader crossed the boundary")
            before = position
            if rooms.clock.now_s() - started_s > rooms.mission.time_limit_s:
                return self._end_pursuit(Outcome.TIMEOUT, f"time limit of {rooms.mission.time_limit_s:g} s")

    def _captured(self) -> tuple[str, tuple[str, ...]] | None:
        """How and by whom, once the evader is captured: by the first contact as this vehicle sees it, else as the team agrees."""
        loop, rooms = self._loop, self._rooms
        if rooms.mission.capture.mode == "first":
            decision = loop.decision
            touched = decision is not None and decision.diagnostics.get("captured") is True and not loop.held
            return ("within the capture radius", (rooms.vehicle.name,)) if touched else None
        capture = loop.coordination.capture
        if capture is None:
            return None
        of = sum(vehicle.role == "pursuer" for vehicle in rooms.mission.vehicles)
        agreed = ", ".join(capture.agreed)
        text = f"encirclement by {len(capture.by)} of {of} pursuers held for the dwell time, agreed by {agreed}"
        return text, capture.by

    def _end_pursuit(self, outcome: Outcome, reason: str, by: tuple[str, ...] = ()) -> Outcome:
        self._failsafes.is_pursuing = False
        self._loop.outcome = outcome.value
        self._loop.hover_here()
        data = {"captured_by": list(by)} if by else {}
        self._rooms.journal.event("info", "outcome", f"{outcome.value}: {reason}", **data)
        return outcome

    async def _is_disarmed(self) -> bool:
        """Whether the vehicle is disarmed, by a heartbeat that is newer than the last wish to arm."""
        if self._arm_asked_s is None:
            return True
        rooms = self._rooms
        asked_s = rooms.clock.now_s()
        while rooms.autopilot.status().heartbeat_s <= asked_s and rooms.clock.now_s() < asked_s + NEWS_TIMEOUT_S:
            await asyncio.sleep(POLL_PERIOD_S)
        return not rooms.autopilot.status().armed

    def _stands(self) -> bool:
        motion = self._rooms.autopilot.motion()
        return motion is not None and abs(float(motion.state.velocity_ned_m_s[2])) < STANDS_M_S

    def _height_m(self) -> float:
        motion = self._rooms.autopilot.motion()
        return -math.inf if motion is None else -float(motion.state.position_ned_m[2])

    def _evader_position(self) -> Point | None:
        """Planar position (north, east) of the evader as measured lately; a prediction alone decides nothing."""
        rooms = self._rooms
        if rooms.vehicle.role == "evader":
            motion = rooms.autopilot.motion()
            return None if motion is None else planar(motion.state.position_ned_m)
        target = self._loop.target
        return None if target is None or target.age_s > TARGET_AGE_MAX_S else planar(target.position_ned_m)


def _ingress(rooms: Rooms, loop: ControlLoop, pace: Pace) -> Ingress | None:
    """What flies the ingress, where the mission plans one for this vehicle."""
    if rooms.mission.ingress != "planned" or rooms.vehicle.station is None:
        return None
    from flightapp.runtime.ingress import Ingress

    return Ingress(rooms, loop, pace)


def _way_out(rooms: Rooms, loop: ControlLoop) -> WayOut | None:
    """What leads a pursuer out of traps, where the mission wants that."""
    if rooms.mission.way_out != "planned" or rooms.vehicle.role != "pursuer":
        return None
    from flightapp.runtime.way_out import WayOut

    return WayOut(rooms, loop)
