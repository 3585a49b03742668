"""The mission executive: preflight, arm, take off, wait for the team, pursue, return, land.

It reads like the mission it flies. Whatever ends the mission early is an `InterruptedMission` with the one action that
follows; the conditions stand in `_check`. The app knows which flight modes it asked for. Any other mode means that the
pilot, or a failsafe of the autopilot, has control: from then on it sends no setpoint and no mode change unless an operator
asks for one. Heartbeats come once a second, so news of arming and mode is waited for before anything rests on it.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Collection
from enum import Enum

from flightapp.core.errors import FlightError
from flightapp.fleet.messages import Command
from flightapp.planning.plane import Point, crosses, planar, segments
from flightapp.preflight.checklist import refuse_unknown, run_checklist
from flightapp.preflight.gathering import Gatherer
from flightapp.preflight.result import Level, Result
from flightapp.runtime.control_loop import ControlLoop, Guidance
from flightapp.runtime.failsafe_conditions import Control, conditions_of
from flightapp.runtime.outcome import Outcome, outcome_of_team
from flightapp.runtime.rooms import Rooms
from flightapp.safety.failsafe.machine import Failsafe, Verdict
from flightapp.safety.failsafe.table import HOW, PERSONS, Condition, State, table_for

POLL_PERIOD_S = 0.02
PREFLIGHT_TIMEOUT_S = 60.0
PREFLIGHT_PERIOD_S = 0.2
STARTED_ALONE = ("team",)
"""Checks that a vehicle does not wait for on the ground: in the air it waits for its team, as the mission says."""
TAKEOFF_TIMEOUT_S = 45.0
MODE_TIMEOUT_S = 5.0
SETPOINTS_BEFORE_OFFBOARD = 15
"""PX4 accepts OFFBOARD only on a running stream (> 2 Hz for more than half a second)."""
RETURN_TIMEOUT_S = 240.0
BRAKE_TIMEOUT_S = 4.0
NEWS_TIMEOUT_S = 3.0
"""How long a heartbeat that tells the present state is waited for; they come once a second."""
SETTLING_S = 0.3
"""From an acknowledged mode command to the first heartbeat that is believed to show its effect."""
RETRY_PERIOD_S = 2.5
GIVE_UP_LANDING_S = 20.0
LINK_GIVE_UP_S = 5.0
"""Silence of a lost link after which the process ends, so that its setpoints end and the autopilot's failsafe acts."""
WATCH_GIVE_UP_S = 30.0
SHORT_HOLD_S = 3.0
HEIGHT_REACHED_FRACTION = 0.9
TARGET_AGE_MAX_S = 1.0
PEER_AGE_MAX_S = 1.0


class Next(Enum):
    """What follows an interrupted mission."""

    RETURN = "return"
    """Fly home and land: the autopilot's return mode."""
    LAND = "land"
    """Land where the vehicle is."""
    TERMINATE = "terminate"
    """End the flight at once, whatever becomes of the vehicle."""
    RELEASE = "release"
    """Leave the vehicle to the pilot or to the autopilot's own failsafe; watch and record until it is disarmed."""


ACTIONS = {
    State.RETURN: Next.RETURN,
    State.LAND: Next.LAND,
    State.TERMINATE: Next.TERMINATE,
    State.PILOT: Next.RELEASE,
}
DOING = {action: state for state, action in ACTIONS.items()} | {Next.RELEASE: State.NORMAL}
"""A vehicle that somebody else flies is not being ended by the app: any wish counts again."""
WISHED = {
    "rtl": (Condition.OPERATOR_RETURN, "returning"),
    "land": (Condition.OPERATOR_LAND, "landing"),
    "abort": (Condition.OPERATOR_ABORT, "landing"),
}
"""Operator commands that end the mission, and the answers to them."""


class InterruptedMission(Exception):  # noqa: N818 - control flow, not an error
    """The mission ends now."""

    def __init__(self, action: Next, outcome: Outcome, reason: str) -> None:
        super().__init__(reason)
        self.action = action
        self.outcome = outcome
        self.reason = reason


class Executive:
    """Flies one mission on one vehicle."""

    def __init__(self, rooms: Rooms, waived: Collection[str] = ()) -> None:
        self._rooms = rooms
        self._waived = waived
        self._loop: ControlLoop
        self._failsafe = Failsafe(table_for(State[rooms.mission.flight_volume.outside_action.upper()]))
        self._wishes: dict[Condition, str] = {}
        """What operators want, and who."""
        self._doing = State.NORMAL
        """How far the mission has been ended already."""
        self._arm_asked_s: float | None = None
        self._own_modes: frozenset[str] = frozenset()
        """Flight modes that this app asked for; empty while it is not in control."""
        self._settling: tuple[float, frozenset[str]] | None = None
        """(time, modes): from the first heartbeat after that time on, only these modes are the app's own."""
        self._pursuing = False
        self._stop_watching = False

    def attach(self, loop: ControlLoop) -> None:
        self._loop = loop

    def request_landing(self, reason: str) -> None:
        """Land as soon as possible (termination signal). A vehicle that somebody else flies is only let go of."""
        if self._loop.phase == "released":
            self._stop_watching = True
        else:
            self._want(Condition.OPERATOR_LAND, reason)

    def on_command(self, command: Command) -> tuple[bool, str]:
        """Operator command -> (accepted, text)."""
        who = f"operator {command.operator}" if command.operator else "operator"
        phase = self._loop.phase
        self._rooms.journal.event("warning", "command", f"{command.action} from {who}", identifier=command.identifier)
        if phase == "done":
            return False, "the mission is over"
        if command.action in ("hold", "resume"):
            if phase not in ("ready", "pursue"):
                return False, f"not possible in phase {phase}"
            if command.action == "resume":
                self._wishes.pop(Condition.OPERATOR_HOLD, None)
                return True, "resumed"
            self._want(Condition.OPERATOR_HOLD, f"hold from {who}")
            return True, "holding position"
        condition, text = WISHED[command.action]
        self._want(condition, f"{command.action} from {who}")
        return True, text

    async def fly(self) -> Outcome:
        """The whole mission; FlightError only where the vehicle cannot be brought down by this app."""
        action, reason = Next.RETURN, "mission complete"
        try:
            await self._preflight()
            await self._take_off()
            await self._wait_for_team()
            outcome = await self._pursue()
        except InterruptedMission as interruption:
            action, outcome, reason = interruption.action, interruption.outcome, interruption.reason
            self._rooms.journal.event("warning", "interrupted", reason, action=action.value, outcome=outcome.value)
        except Exception as error:  # Whatever broke, the vehicle must still come down.
            action, outcome, reason = Next.LAND, Outcome.FAULT, str(error) or type(error).__name__
            self._rooms.journal.event("error", "fault", reason, kind=type(error).__name__)
        self._loop.outcome = outcome.value
        if await self._is_disarmed():
            self._enter("done", reason)
            return outcome
        return await self._bring_down(action, outcome, reason)

    async def _preflight(self) -> None:
        """Go through the checklist until it is passed, waived or failed; what converges is waited for."""
        rooms = self._rooms
        self._enter("preflight", "")
        gatherer = Gatherer(rooms, self._loop)
        await gatherer.read_parameters()
        deadline = rooms.clock.now_s() + PREFLIGHT_TIMEOUT_S
        while True:
            results = run_checklist(gatherer.facts(), self._waived)
            running = [result for result in results if result.level is Level.RUNNING and result.check not in STARTED_ALONE]
            if any(result.level is Level.FAILED for result in results) or not running:
                break
            if rooms.clock.now_s() > deadline:
                raise FlightError(f"preflight: not ready within {PREFLIGHT_TIMEOUT_S:g} s: {_told(running)}")
            await self._tick(PREFLIGHT_PERIOD_S)
        refuse_unknown(self._waived, results)
        self._record(results)
        failed = [result for result in results if result.level is Level.FAILED]
        if failed:
            raise FlightError(f"preflight: {_told(failed)}")
        height = rooms.mission.height_of(rooms.vehicle) - rooms.vehicle.start.ground_height_m
        return_height = rooms.mission.return_height_of(rooms.vehicle) - rooms.vehicle.start.ground_height_m
        await rooms.autopilot.set_heights(height, return_height)

    def _record(self, results: list[Result]) -> None:
        """The checklist as it was passed: waivers and warnings as events of their own."""
        for result in results:
            if result.level in (Level.WAIVED, Level.WARNING, Level.FAILED):
                text = f"{result.check} {result.level.word}: {result.found}"
                self._rooms.journal.event("warning", "preflight", text, check=result.check, result=result.level.word)
        passed = sum(result.level is Level.PASSED for result in results)
        self._rooms.journal.event("info", "preflight", f"{passed} of {len(results)} checks passed")

    async def _take_off(self) -> None:
        rooms, loop = self._rooms, self._loop
        self._enter("arm", "")
        self._check()
        self._arm_asked_s = rooms.clock.now_s()
        await rooms.autopilot.arm()
        self._check()
        self._enter("takeoff", "")
        await rooms.autopilot.takeoff()
        self._take_control("TAKEOFF", "HOLD")
        await self._climb()
        loop.hover_here()
        streaming = loop.setpoints_sent + SETPOINTS_BEFORE_OFFBOARD
        await self._until(lambda: loop.setpoints_sent >= streaming, MODE_TIMEOUT_S, "no setpoints were sent")
        await rooms.autopilot.start_offboard()
        self._take_control("OFFBOARD")
        await self._until(lambda: rooms.autopilot.status().flight_mode == "OFFBOARD", MODE_TIMEOUT_S, "OFFBOARD was not reported")
        loop.in_offboard = True

    async def _climb(self) -> None:
        """Wait for the height. HOLD follows a finished take-off; a HOLD that stays below it was somebody's choice."""
        rooms = self._rooms
        ground = rooms.vehicle.start.ground_height_m
        wanted = ground + HEIGHT_REACHED_FRACTION * (rooms.mission.height_of(rooms.vehicle) - ground)
        deadline = rooms.clock.now_s() + TAKEOFF_TIMEOUT_S
        climbing_s = rooms.clock.now_s()
        while self._height_m() < wanted:
            now_s = rooms.clock.now_s()
            settled = self._settling is None
            if not (settled and rooms.autopilot.status().flight_mode == "HOLD"):
                climbing_s = now_s
            if now_s - climbing_s > SHORT_HOLD_S:
                self._give_up_control()
                raise InterruptedMission(Next.RELEASE, Outcome.ABORTED, "HOLD below the mission height: not this app's choice")
            if now_s > deadline:
                raise FlightError(f"take-off did not reach {wanted:.1f} m (waited {TAKEOFF_TIMEOUT_S:g} s)")
            await self._tick()

    async def _wait_for_team(self) -> None:
        rooms = self._rooms
        self._enter("ready", "")
        deadline = rooms.clock.now_s() + rooms.mission.start_timeout_s
        while waiting := self._not_ready():
            if rooms.clock.now_s() > deadline:
                raise FlightError(f"the team was not ready within {rooms.mission.start_timeout_s:g} s: {', '.join(waiting)}")
            await self._tick()

    async def _pursue(self) -> Outcome:
        rooms, loop = self._rooms, self._loop
        self._enter("pursue", "")
        rooms.planner.reset()
        loop.guidance = Guidance.PLANNER
        self._pursuing = True
        started_s = rooms.clock.now_s()
        before = None
        edge = segments(rooms.boundary)
        while True:
            await self._tick()
            told = outcome_of_team(peer.state.outcome for peer in rooms.team.peers.values() if peer.state is not None)
            if told is not None:
                return self._end_pursuit(told, "told by the team")
            decision = loop.decision
            if decision is not None and decision.diagnostics.get("captured") is True and not loop.held:
                return self._end_pursuit(Outcome.CAPTURED, "encirclement held for the dwell time")
            position = self._evader_position()
            if position is not None and before is not None and crosses(before, position, edge):
                return self._end_pursuit(Outcome.ESCAPED, "the evader crossed the boundary")
            before = position
            if rooms.clock.now_s() - started_s > rooms.mission.time_limit_s:
                return self._end_pursuit(Outcome.TIMEOUT, f"time limit of {rooms.mission.time_limit_s:g} s")

    def _end_pursuit(self, outcome: Outcome, reason: str) -> Outcome:
        self._pursuing = False
        self._loop.outcome = outcome.value
        self._loop.hover_here()
        self._rooms.journal.event("info", "outcome", f"{outcome.value}: {reason}")
        return outcome

    async def _bring_down(self, action: Next, outcome: Outcome, reason: str) -> Outcome:
        """Return or land, whatever happens on the way, until the vehicle is disarmed."""
        self._pursuing = False
        while True:
            try:
                await self._execute(action, outcome, reason)
                self._enter("done", "disarmed" if not self._stop_watching else "no longer watched")
                return outcome
            except InterruptedMission as change:
                if change.outcome is Outcome.FAULT:
                    outcome = Outcome.FAULT
                action, reason = change.action, change.reason
                self._rooms.journal.event("warning", "interrupted", reason, action=action.value)
            except FlightError as error:
                self._loop.outcome = Outcome.FAULT.value
                self._rooms.journal.event("error", "fault", str(error))
                self._enter("done", "the app cannot bring the vehicle down: the autopilot's failsafe must")
                raise

    async def _execute(self, action: Next, outcome: Outcome, reason: str) -> None:
        rooms, loop = self._rooms, self._loop
        loop.outcome = outcome.value
        self._doing = DOING[action]
        if action is Next.RELEASE:
            loop.guidance = Guidance.NONE
            self._enter("released", reason)
            await self._watch_until_disarmed()
            return
        self._enter(action.value, reason)
        if action is Next.TERMINATE:
            loop.guidance = Guidance.NONE
            await rooms.autopilot.terminate()
            await self._watch_until_disarmed()
            return
        if loop.guidance is not Guidance.NONE and loop.failure is None:
            await self._brake()
        if action is Next.RETURN:
            await self._insist(rooms.autopilot.return_to_launch, "RETURN_TO_LAUNCH", "LAND")
        elif rooms.autopilot.status().landed_state == "ON_GROUND" and await self._disarmed_on_the_ground():
            return
        else:
            await self._insist(rooms.autopilot.land, "LAND")
        loop.guidance = Guidance.NONE
        await self._until(
            lambda: not rooms.autopilot.status().armed,
            RETURN_TIMEOUT_S,
            f"not on the ground {RETURN_TIMEOUT_S:g} s after '{action.value}'",
        )

    async def _disarmed_on_the_ground(self) -> bool:
        """Disarm a vehicle that stands; the autopilot refuses it to one that flies, whatever was reported."""
        try:
            await self._rooms.autopilot.disarm()
        except FlightError:
            return False
        return True

    async def _watch_until_disarmed(self) -> None:
        """Somebody else flies: record until the vehicle is disarmed, or the link has been dead for long."""
        rooms = self._rooms
        while rooms.autopilot.status().armed and not self._stop_watching:
            if rooms.clock.now_s() - rooms.autopilot.status().heartbeat_s > WATCH_GIVE_UP_S:
                raise FlightError(f"no heartbeat of the autopilot for {WATCH_GIVE_UP_S:g} s after the app gave up control")
            await self._tick()

    async def _brake(self) -> None:
        """Come to rest under the guards before the autopilot takes over: its own modes do not know the obstacles."""
        self._loop.hover_here()
        give_up_s = self._rooms.clock.now_s() + BRAKE_TIMEOUT_S
        while not self._loop.is_hovering and self._rooms.clock.now_s() < give_up_s:
            await self._tick()

    async def _insist(self, command: Callable[[], Awaitable[None]], *modes: str) -> None:
        """Command a mode until the autopilot reports it. Nothing is commanded before news of the present mode was judged."""
        rooms = self._rooms
        give_up_s = rooms.clock.now_s() + GIVE_UP_LANDING_S
        while True:
            await self._news()
            if not rooms.autopilot.status().armed or rooms.autopilot.status().flight_mode in modes:
                return
            if rooms.clock.now_s() > give_up_s:
                raise FlightError(f"the autopilot did not change to {modes[0]} within {GIVE_UP_LANDING_S:g} s")
            try:
                await command()
            except Exception as error:  # A refusal, or MAVSDK itself: try again until it is time to give up.
                rooms.journal.event("error", "command_failed", str(error))
            else:
                self._take_control(*modes)
            retry_s = rooms.clock.now_s() + RETRY_PERIOD_S
            while rooms.clock.now_s() < retry_s:
                if rooms.autopilot.status().flight_mode in modes or not rooms.autopilot.status().armed:
                    return
                await self._tick()

    async def _news(self) -> None:
        """Wait for a heartbeat and judge it. On a lost link none comes: then end, so that the setpoints end too."""
        rooms = self._rooms
        asked_s = rooms.clock.now_s()
        while rooms.autopilot.status().heartbeat_s <= asked_s:
            if rooms.clock.now_s() - rooms.autopilot.status().heartbeat_s > NEWS_TIMEOUT_S + LINK_GIVE_UP_S:
                raise FlightError(f"autopilot link lost: no heartbeat for {NEWS_TIMEOUT_S + LINK_GIVE_UP_S:g} s")
            await self._tick()

    async def _is_disarmed(self) -> bool:
        """Whether the vehicle is disarmed, by a heartbeat that is newer than the last wish to arm."""
        if self._arm_asked_s is None:
            return True
        rooms = self._rooms
        asked_s = rooms.clock.now_s()
        while rooms.autopilot.status().heartbeat_s <= asked_s and rooms.clock.now_s() < asked_s + NEWS_TIMEOUT_S:
            await asyncio.sleep(POLL_PERIOD_S)
        return not rooms.autopilot.status().armed

    async def _until(self, condition: Callable[[], bool], timeout_s: float, failure: str) -> None:
        deadline = self._rooms.clock.now_s() + timeout_s
        while not condition():
            if self._rooms.clock.now_s() > deadline:
                raise FlightError(f"{failure} (waited {timeout_s:g} s)")
            await self._tick()

    async def _tick(self, period_s: float = POLL_PERIOD_S) -> None:
        """Let the control loop run, then look whether something ends the mission."""
        await asyncio.sleep(period_s)
        self._check()

    def _check(self) -> None:
        """The conditions that end a mission, most urgent first."""
        status = self._rooms.autopilot.status()
        if self._settling is not None and status.heartbeat_s > self._settling[0]:
            self._own_modes, self._settling = self._settling[1], None
        now_s = self._rooms.clock.now_s()
        control = Control(bool(self._own_modes), status.flight_mode in self._own_modes, self._pursuing)
        active = {*conditions_of(self._rooms, self._loop, control, now_s), *self._wishes}
        verdict = self._failsafe.step(now_s, active)
        self._loop.held = verdict.state is State.HOLD
        if verdict.is_new:
            self._obey(verdict)

    def _obey(self, verdict: Verdict) -> None:
        """Record the failsafe's new state and, where it ends the mission more than it is ended already, end it."""
        row = verdict.row
        if row is None:
            self._rooms.journal.event("info", "failsafe", "NORMAL: nothing is wrong any more", state="NORMAL")
            return
        reason = f"{row.condition}: {self._wishes.get(row.condition) or self._detail(row.condition)}"
        text = f"{verdict.state.name} because of {reason}"
        self._rooms.journal.event("warning", "failsafe", text, state=verdict.state.name, condition=row.condition, by=row.by)
        if verdict.state is State.PILOT:
            self._give_up_control()
        elif verdict.state <= max(State.HOLD, self._doing):
            return
        outcome = Outcome.ABORTED if row.condition in PERSONS else Outcome.FAULT
        raise InterruptedMission(ACTIONS[verdict.state], outcome, reason)

    def _detail(self, condition: Condition) -> str:
        """What exactly is wrong, where more is known than the condition's name."""
        loop, status = self._loop, self._rooms.autopilot.status()
        failure = None if loop.perception is None else loop.perception.failure
        known = {
            Condition.PILOT_HAS_CONTROL: f"{status.flight_mode}: the pilot or the autopilot's failsafe has control",
            Condition.LINK_LOST: "autopilot link lost: no heartbeat for 3 s",
            Condition.DISARMED_IN_FLIGHT: "disarmed in flight",
            Condition.LOOP_FAILED: f"control loop failed: {loop.failure}",
            Condition.PLANNER_FAILED: f"planner failed: {loop.planner_failure}",
            Condition.CAMERA_LOST: "" if failure is None else f"perception failed: {failure}",
            Condition.RECORDING_FAILED: str(self._rooms.journal.recording_error),
        }
        demand = "" if loop.demand is None else loop.demand.reason
        return known.get(condition) or demand or HOW[condition]

    def _take_control(self, *modes: str) -> None:
        """The autopilot acknowledged `modes`; the mode it had counts as the app's own until a heartbeat can show the new one."""
        present = self._rooms.autopilot.status().flight_mode
        self._own_modes = frozenset((*modes, *self._own_modes, present))
        self._settling = (self._rooms.clock.now_s() + SETTLING_S, frozenset(modes))

    def _give_up_control(self) -> None:
        self._own_modes, self._settling = frozenset(), None
        self._loop.in_offboard = False
        self._loop.guidance = Guidance.NONE

    def _want(self, condition: Condition, reason: str) -> None:
        """A person's wish, from now on and anew."""
        self._failsafe.renew(condition)
        self._wishes[condition] = reason

    def _enter(self, phase: str, reason: str) -> None:
        self._loop.phase = phase
        self._rooms.journal.phase(phase, reason, self._loop.outcome)

    def _height_m(self) -> float:
        motion = self._rooms.autopilot.motion()
        return -math.inf if motion is None else -float(motion.state.position_ned_m[2])

    def _not_ready(self) -> list[str]:
        """Who of the team is missing, and why."""
        now_s = self._rooms.clock.now_s()
        waiting = []
        for name, peer in self._rooms.team.peers.items():
            state = peer.state
            if state is None:
                waiting.append(f"{name} (not heard)")
            elif state.mission != self._rooms.mission_digest:
                waiting.append(f"{name} (flies another version of the mission file)")
            elif now_s - state.t_s > PEER_AGE_MAX_S:
                waiting.append(f"{name} (silent for {now_s - state.t_s:.0f} s)")
            elif state.phase not in ("ready", "pursue"):
                waiting.append(f"{name} (in phase {state.phase})")
        return waiting

    def _evader_position(self) -> Point | None:
        """Planar position (north, east) of the evader as measured lately; a prediction alone decides nothing."""
        rooms = self._rooms
        if rooms.vehicle.role == "evader":
            motion = rooms.autopilot.motion()
            return None if motion is None else planar(motion.state.position_ned_m)
        target = self._loop.target
        return None if target is None or target.age_s > TARGET_AGE_MAX_S else planar(target.position_ned_m)


def _told(results: list[Result]) -> str:
    return "; ".join(f"{result.check}: {result.found}{f' -> {result.remedy}' if result.remedy else ''}" for result in results)
