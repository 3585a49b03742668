"""The failsafe table at work in one vehicle: conditions and wishes in, events and the end of the mission out."""

from __future__ import annotations

from flightapp.runtime.authority import Authority
from flightapp.runtime.control_loop import ControlLoop, Guidance
from flightapp.runtime.failsafe_conditions import Control, conditions_of
from flightapp.runtime.interruption import ACTIONS, InterruptedMission, Next
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.rooms import Rooms
from flightapp.safety.failsafe.machine import Failsafe, Verdict
from flightapp.safety.failsafe.table import HOW, PERSONS, Condition, State, table_for


class FailsafeWatch:
    """`look` is called every few hundredths of a second; what ends the mission leaves it as an `InterruptedMission`."""

    def __init__(self, rooms: Rooms, loop: ControlLoop, authority: Authority) -> None:
        self._rooms = rooms
        self._loop = loop
        self._authority = authority
        self._machine = Failsafe(table_for(State[rooms.mission.flight_volume.outside_action.upper()]))
        self._wishes: dict[Condition, str] = {}
        """What operators want, and who."""
        self.is_pursuing = False
        """Planner, camera and team are judged while this is True."""
        self.doing = State.NORMAL
        """How far the mission has been ended already."""

    def want(self, condition: Condition, reason: str) -> None:
        """A person's wish, from now on and anew."""
        self._machine.renew(condition)
        self._wishes[condition] = reason

    def withdraw(self, condition: Condition) -> None:
        """The person no longer wants it."""
        self._wishes.pop(condition, None)

    def look(self) -> None:
        """One step of the state machine; InterruptedMission where its new state ends the mission."""
        self._authority.settle()
        now_s = self._rooms.clock.now_s()
        control = Control(self._authority.is_held, self._authority.is_own_mode, self.is_pursuing)
        verdict = self._machine.step(now_s, {*conditions_of(self._rooms, self._loop, control, now_s), *self._wishes})
        self._loop.held = verdict.state is State.HOLD
        if verdict.is_new:
            self._obey(verdict)

    def release(self, reason: str) -> InterruptedMission:
        """Give up control and stop commanding at once; returns what the mission ends with."""
        self._authority.give_up()
        self._loop.in_offboard = False
        self._loop.guidance = Guidance.NONE
        return InterruptedMission(Next.RELEASE, Outcome.ABORTED, reason)

    def _obey(self, verdict: Verdict) -> None:
        """Record the failsafe's new state and, where it ends the mission more than it is ended already, end it."""
        row = verdict.row
        if row is None:
            self._rooms.journal.event("info", "failsafe", "NORMAL: nothing is wrong any more", state="NORMAL")
            return
        reason = f"{row.condition}: {self._wishes.get(row.condition) or self._detail(row.condition)}"
        text = f"{verdict.state.name} because of {reason}"
        self._rooms.journal.event("warning", "failsafe", text, state=verdict.state.name, condition=row.condition, by=row.by)
        outcome = Outcome.ABORTED if row.condition in PERSONS else Outcome.FAULT
        if verdict.state is State.PILOT:
            release = self.release(reason)
            release.outcome = outcome
            raise release
        if verdict.state > max(State.HOLD, self.doing):
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
