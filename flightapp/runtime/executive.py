"""The mission executive: preflight, arm, take off, wait for the team, pursue, return, land.

It reads like the mission it flies. Whatever ends the mission early is an `InterruptedMission` with the one action that
follows; the table of conditions stands in `_check`. After a take-over by the pilot, or a failsafe of the autopilot, the
app sends no mode change and no setpoint any more unless a person asks for it.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from enum import Enum

from flightapp.core.errors import FlightError
from flightapp.core.types import Array
from flightapp.fleet.messages import Command
from flightapp.runtime.control_loop import ControlLoop, Guidance, Rooms
from flightapp.runtime.outcome import Outcome, crosses, outcome_of_team

POLL_PERIOD_S = 0.02
PREFLIGHT_TIMEOUT_S = 60.0
TAKEOFF_TIMEOUT_S = 45.0
MODE_TIMEOUT_S = 5.0
SETPOINTS_BEFORE_OFFBOARD = 15
"""PX4 accepts OFFBOARD only on a running stream (> 2 Hz for more than half a second)."""
RETURN_TIMEOUT_S = 240.0
BRAKE_TIMEOUT_S = 4.0
RETRY_PERIOD_S = 1.0
GIVE_UP_LANDING_S = 20.0
LINK_GIVE_UP_S = 30.0
BATTERY_MIN_FRACTION = 0.2
PILOT_MODES = ("MANUAL", "ALTCTL", "POSCTL", "ACRO", "STABILIZED", "RATTITUDE")
HEIGHT_REACHED_FRACTION = 0.9


class Next(Enum):
    """What follows an interrupted mission."""

    RETURN = "return"
    """Fly home and land: the autopilot's return mode."""
    LAND = "land"
    """Land where the vehicle is."""
    RELEASE = "release"
    """Leave the vehicle to the pilot or to the autopilot's own failsafe; watch and record until it is disarmed."""


class InterruptedMission(Exception):  # noqa: N818 - control flow, not an error
    """The mission ends now."""

    def __init__(self, action: Next, outcome: Outcome, reason: str) -> None:
        super().__init__(reason)
        self.action = action
        self.outcome = outcome
        self.reason = reason


class Executive:
    """Flies one mission on one vehicle."""

    def __init__(self, rooms: Rooms) -> None:
        self._rooms = rooms
        self._loop: ControlLoop
        self._wanted: InterruptedMission | None = None
        self._in_control = False
        self._in_offboard = False
        self._pursuing = False
        self._failure_handled = False
        self._link_lost = False

    def attach(self, loop: ControlLoop) -> None:
        self._loop = loop

    def request_landing(self, reason: str) -> None:
        """Land as soon as possible (termination signal)."""
        self._want(Next.LAND, reason)

    def on_command(self, command: Command) -> tuple[bool, str]:
        """Operator command -> (accepted, text)."""
        who = f"operator {command.operator}" if command.operator else "operator"
        self._rooms.journal.event("warning", "command", f"{command.action} from {who}", identifier=command.identifier)
        match command.action:
            case "hold":
                self._loop.held = True
                return True, "holding position"
            case "resume":
                self._loop.held = False
                return True, "resumed"
            case "rtl":
                self._want(Next.RETURN, f"rtl from {who}")
                return True, "returning"
            case _:
                self._want(Next.LAND, f"{command.action} from {who}")
                return True, "landing"

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
        if not self._rooms.autopilot.status().armed:
            self._enter("done", reason)
            return outcome
        return await self._bring_down(action, outcome, reason)

    async def _preflight(self) -> None:
        """Wait until the autopilot is ready, say what is missing when it is not; a converging GPS is not a failure."""
        rooms = self._rooms
        self._enter("preflight", "")
        deadline = rooms.clock.now_s() + PREFLIGHT_TIMEOUT_S
        while missing := self._missing():
            if rooms.clock.now_s() > deadline:
                raise FlightError(f"preflight: not ready within {PREFLIGHT_TIMEOUT_S:g} s: {'; '.join(missing)}")
            await self._tick()
        battery = rooms.autopilot.battery()
        if battery is not None and battery.remaining_fraction is not None and battery.remaining_fraction < BATTERY_MIN_FRACTION:
            raise FlightError(
                f"preflight: battery at {battery.remaining_fraction:.0%}, at least {BATTERY_MIN_FRACTION:.0%} is needed"
            )
        height = rooms.mission.height_of(rooms.vehicle) - rooms.vehicle.start.ground_height_m
        return_height = rooms.mission.return_height_of(rooms.vehicle) - rooms.vehicle.start.ground_height_m
        await rooms.autopilot.set_heights(height, return_height)

    def _missing(self) -> list[str]:
        rooms = self._rooms
        missing = list(rooms.autopilot.health().missing())
        if rooms.autopilot.motion() is None:
            missing.append("position")
        if self._loop.perception is not None and self._loop.perception.newest is None:
            missing.append(f"depth frames{f' ({self._loop.perception.failure})' if self._loop.perception.failure else ''}")
        return missing

    async def _take_off(self) -> None:
        rooms = self._rooms
        self._enter("arm", "")
        await rooms.autopilot.arm()
        self._enter("takeoff", "")
        await rooms.autopilot.takeoff()
        await self._until(
            lambda: rooms.autopilot.status().flight_mode in ("TAKEOFF", "HOLD"), MODE_TIMEOUT_S, "TAKEOFF was not reported"
        )
        self._in_control = True
        ground = rooms.vehicle.start.ground_height_m
        wanted = ground + HEIGHT_REACHED_FRACTION * (rooms.mission.height_of(rooms.vehicle) - ground)
        await self._until(lambda: self._height_m() >= wanted, TAKEOFF_TIMEOUT_S, f"take-off did not reach {wanted:.1f} m")
        self._loop.hover_here()
        streaming = self._loop.setpoints_sent + SETPOINTS_BEFORE_OFFBOARD
        await self._until(lambda: self._loop.setpoints_sent >= streaming, MODE_TIMEOUT_S, "no setpoints were sent")
        await rooms.autopilot.start_offboard()
        await self._until(lambda: rooms.autopilot.status().flight_mode == "OFFBOARD", MODE_TIMEOUT_S, "OFFBOARD was not reported")
        self._in_offboard = self._loop.in_offboard = True

    async def _wait_for_team(self) -> None:
        rooms = self._rooms
        self._enter("ready", "")
        await self._until(
            self._team_is_ready, rooms.mission.start_timeout_s, "the team was not ready in time", self._who_is_not_ready
        )

    async def _pursue(self) -> Outcome:
        rooms, loop = self._rooms, self._loop
        self._enter("pursue", "")
        rooms.planner.reset()
        loop.guidance = Guidance.PLANNER
        self._pursuing = True
        started_s = rooms.clock.now_s()
        before = None
        while True:
            await self._tick()
            told = outcome_of_team(peer.state.outcome for peer in rooms.team.peers.values() if peer.state is not None)
            if told is not None:
                return self._end_pursuit(told, "told by the team")
            decision = loop.decision
            if decision is not None and decision.diagnostics.get("captured") is True:
                return self._end_pursuit(Outcome.CAPTURED, "encirclement held for the dwell time")
            position = self._evader_position()
            if position is not None:
                if before is not None and crosses(rooms.boundary, before, position):
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
        self._in_offboard = False
        while True:
            try:
                await self._execute(action, outcome, reason)
                self._enter("done", "disarmed")
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
        if action is Next.RELEASE:
            loop.guidance = Guidance.NONE
            self._enter("released", reason)
            await self._watch_until_disarmed()
            return
        self._enter(action.value, reason)
        if loop.guidance is not Guidance.NONE and loop.failure is None:
            await self._brake()
        command = rooms.autopilot.return_to_launch if action is Next.RETURN else rooms.autopilot.land
        modes = ("RETURN_TO_LAUNCH", "LAND") if action is Next.RETURN else ("LAND",)
        await self._insist(command, modes)
        loop.guidance = Guidance.NONE
        await self._until(
            lambda: not rooms.autopilot.status().armed,
            RETURN_TIMEOUT_S,
            f"not on the ground {RETURN_TIMEOUT_S:g} s after '{action.value}'",
        )

    async def _watch_until_disarmed(self) -> None:
        """Somebody else flies: record until the vehicle is disarmed, or the link has been dead for long."""
        rooms = self._rooms
        while rooms.autopilot.status().armed:
            silent_s = rooms.clock.now_s() - rooms.autopilot.status().heartbeat_s
            if silent_s > LINK_GIVE_UP_S:
                raise FlightError(f"no heartbeat of the autopilot for {LINK_GIVE_UP_S:g} s after the app gave up control")
            await self._tick()

    async def _brake(self) -> None:
        """Come to rest under the guards before the autopilot takes over: its own modes do not know the obstacles."""
        self._loop.hover_here()
        give_up_s = self._rooms.clock.now_s() + BRAKE_TIMEOUT_S
        while not self._loop.is_hovering and self._rooms.clock.now_s() < give_up_s:
            await self._tick()

    async def _insist(self, command: Callable[[], Awaitable[None]], modes: tuple[str, ...]) -> None:
        """Repeat a mode command until the autopilot reports the mode; setpoints keep flowing meanwhile."""
        rooms = self._rooms
        give_up_s = rooms.clock.now_s() + GIVE_UP_LANDING_S
        while rooms.autopilot.status().armed:
            refusal = ""
            try:
                await command()
            except FlightError as error:
                refusal = str(error)
                rooms.journal.event("error", "command_failed", refusal)
            retry_s = rooms.clock.now_s() + RETRY_PERIOD_S
            while rooms.clock.now_s() < retry_s:
                if rooms.autopilot.status().flight_mode in modes or not rooms.autopilot.status().armed:
                    return
                await self._tick()
            if rooms.clock.now_s() > give_up_s:
                raise FlightError(f"the autopilot did not change to {modes[0]} within {GIVE_UP_LANDING_S:g} s {refusal}".rstrip())

    async def _until(
        self, condition: Callable[[], bool], timeout_s: float, failure: str, detail: Callable[[], str] | None = None
    ) -> None:
        deadline = self._rooms.clock.now_s() + timeout_s
        while not condition():
            if self._rooms.clock.now_s() > deadline:
                raise FlightError(f"{failure}{f': {detail()}' if detail is not None else ''} (waited {timeout_s:g} s)")
            await self._tick()

    async def _tick(self) -> None:
        """Let the control loop run, then look whether something ends the mission."""
        await asyncio.sleep(POLL_PERIOD_S)
        self._check()

    def _check(self) -> None:
        """The conditions that end a mission, most urgent first."""
        status = self._rooms.autopilot.status()
        if self._in_control and status.flight_mode in PILOT_MODES:
            self._in_control = self._in_offboard = False
            raise InterruptedMission(Next.RELEASE, Outcome.ABORTED, f"{status.flight_mode}: the pilot has control")
        if self._in_offboard and status.flight_mode != "OFFBOARD":
            self._in_control = self._in_offboard = False
            raise InterruptedMission(Next.RELEASE, Outcome.ABORTED, f"{status.flight_mode}: the autopilot's failsafe has control")
        if self._in_control and not status.connected and not self._link_lost:
            self._link_lost = True
            raise InterruptedMission(Next.LAND, Outcome.FAULT, "autopilot link lost: no heartbeat for 3 s")
        if self._in_offboard and not status.armed:
            raise InterruptedMission(Next.RELEASE, Outcome.FAULT, "disarmed in flight")
        if self._wanted is not None:
            wanted, self._wanted = self._wanted, None
            raise wanted
        if self._loop.failure is not None and not self._failure_handled:
            self._failure_handled = True
            raise InterruptedMission(Next.LAND, Outcome.FAULT, f"control loop failed: {self._loop.failure}")
        if self._pursuing and self._loop.planner_failure is not None:
            raise InterruptedMission(Next.LAND, Outcome.FAULT, f"planner failed: {self._loop.planner_failure}")
        perception = self._loop.perception
        if self._pursuing and perception is not None and perception.failure is not None:
            raise InterruptedMission(Next.LAND, Outcome.FAULT, f"perception failed: {perception.failure}")

    def _want(self, action: Next, reason: str) -> None:
        self._wanted = InterruptedMission(action, Outcome.ABORTED, reason)

    def _enter(self, phase: str, reason: str) -> None:
        self._loop.phase = phase
        self._rooms.journal.phase(phase, reason, self._loop.outcome)

    def _height_m(self) -> float:
        motion = self._rooms.autopilot.motion()
        return -math.inf if motion is None else -float(motion.state.position_ned_m[2])

    def _team_is_ready(self) -> bool:
        return not self._not_ready()

    def _who_is_not_ready(self) -> str:
        return ", ".join(self._not_ready())

    def _not_ready(self) -> list[str]:
        return [
            name
            for name, peer in self._rooms.team.peers.items()
            if peer.state is None or peer.state.phase not in ("ready", "pursue")
        ]

    def _evader_position(self) -> Array | None:
        """Planar position (2,) of the evader as known here."""
        rooms = self._rooms
        if rooms.vehicle.role == "evader":
            motion = rooms.autopilot.motion()
            return None if motion is None else motion.state.position_ned_m[:2]
        return None if self._loop.target is None else self._loop.target.position_ned_m[:2]
