"""The team's plan and the agreement on the capture, as the control loop runs them: messages in and out, recording, events."""

from __future__ import annotations

from flightapp.core.types import Assignment, Decision, ObstacleSet, TargetTrack, TeamMember
from flightapp.fleet.coordination.agreement import Agreement, Capture, Verdict
from flightapp.fleet.coordination.core import Coordinator, Voice
from flightapp.fleet.coordination.plan import Plan
from flightapp.fleet.coordination.scene import Scene, pursuer_of
from flightapp.fleet.coordination.sector_plan import SectorPlan
from flightapp.fleet.messages.plan import PLAN
from flightapp.fleet.messages.verdict import VERDICT
from flightapp.planning.capture import CaptureRule
from flightapp.runtime.leadership import Leadership
from flightapp.runtime.outcome import outcome_of_team
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.teamwork import ACTIVE_PHASES, Teamwork

WAITING = 4
VERDICT_PERIOD_S = 0.1


class Coordination:
    """Polled once a control period. A vehicle that is no pursuer takes no part."""

    def __init__(self, rooms: Rooms, teamwork: Teamwork, leadership: Leadership) -> None:
        self._rooms = rooms
        self._teamwork = teamwork
        self._leadership = leadership
        self._takes_part = rooms.vehicle.role == "pursuer"
        self._configured = tuple(vehicle.name for vehicle in rooms.mission.vehicles if vehicle.role == "pursuer")
        self._coordinator = Coordinator(rooms.team_plan or SectorPlan(_ring_radius_m(rooms)))
        self._agreement = Agreement(rooms.vehicle.name)
        self._verdict_due_s = -float("inf")
        self.capture: Capture | None = None
        """Set once the capture by the whole team is agreed on."""
        if self._takes_part:
            post = rooms.team.post
            self._plans_out, self._plans_in = post.outlet(PLAN), post.inlet(PLAN, depth=WAITING)
            self._verdicts_out, self._verdicts_in = post.outlet(VERDICT), post.inlet(VERDICT)

    @property
    def plan(self) -> Plan | None:
        """The one in force; it stays when nobody leads."""
        return self._coordinator.plan

    @property
    def assigned(self) -> tuple[str, ...]:
        """Who is to encircle: the plan's members; before the first plan all of the mission's pursuers."""
        return self._configured if self.plan is None else self.plan.members

    def assignment(self) -> Assignment | None:
        """The own part, for the planner."""
        return self._coordinator.assignment(self._rooms.vehicle.name)

    def partners(self, now_s: float) -> tuple[TeamMember, ...]:
        """Teammates for the planner: all that take part, but who fell silent and was planned without."""
        silent, assigned = self._teamwork.silent, self.assigned
        members = self._teamwork.members(now_s, active_only=True)
        return tuple(member for member in members if member.name not in silent or member.name in assigned)

    def poll(self, now_s: float, phase: str, target: TargetTrack | None, obstacles: ObstacleSet, judged: Decision | None) -> None:
        """Take what was heard, plan if this vehicle leads, vote. judged: the planner's last decision, if that is flown."""
        if not self._takes_part:
            return
        voice = Voice(self._leadership.leader, self._leadership.term, self._leadership.is_leader(now_s))
        before = self.plan
        scene = self._scene(now_s, phase, target, obstacles)
        for plan in self._coordinator.step(now_s, voice, scene, self._plans_in.take(now_s)):
            self._plans_out.put(plan, now_s)
        self._tell(before, voice, now_s)
        own = self._own_verdict(now_s, judged)
        if own is not None and now_s >= self._verdict_due_s:
            self._verdict_due_s = now_s + VERDICT_PERIOD_S
            self._verdicts_out.put(own, now_s)
        agreed = self._agreement.step(now_s, voice, self.assigned, own, self._verdicts_in.take(now_s))
        if self.capture is None and phase == "pursue":
            self.capture = agreed

    def _own_verdict(self, now_s: float, judged: Decision | None) -> Verdict | None:
        if judged is None or judged.diagnostics.get("captured") is not True:
            return None
        return Verdict(frozenset((self._rooms.vehicle.name, *(member.name for member in self.partners(now_s)))))

    def _scene(self, now_s: float, phase: str, target: TargetTrack | None, obstacles: ObstacleSet) -> Scene | None:
        """All that take part now, as long as there is something to plan for. Who is silent does not take part."""
        rooms = self._rooms
        if target is None or self._is_over():
            return None
        members = self._teamwork.members(now_s, active_only=True)
        speed_of = {vehicle.name: vehicle.speed_max_m_s for vehicle in rooms.mission.vehicles}
        places = [(member.name, member.state) for member in members if member.name not in self._teamwork.silent]
        motion = rooms.autopilot.motion()
        if motion is not None and phase in ACTIVE_PHASES:
            places.append((rooms.vehicle.name, motion.state))
        fastest = rooms.profile.limits.speed_max_m_s
        pursuers = tuple(
            pursuer_of(name, state, min(speed_of[name] or fastest, fastest))
            for name, state in sorted(places, key=lambda place: place[0])
        )
        north, east, _ = map(float, target.position_ned_m)
        v_north, v_east, _ = map(float, target.velocity_ned_m_s)
        return Scene(north, east, v_north, v_east, pursuers, obstacles.discs)

    def _is_over(self) -> bool:
        """Whether the pursuit has ended for all: who then flies home has not dropped out."""
        told = (peer.state.outcome for peer in self._rooms.team.peers.values() if peer.state is not None)
        return self.capture is not None or outcome_of_team(told) is not None

    def _tell(self, before: Plan | None, voice: Voice, now_s: float) -> None:
        """Every plan is recorded; an event tells who joins, who drops out, and that sides were exchanged."""
        plan = self.plan
        if plan is None or plan is before:
            return
        author = self._rooms.vehicle.name if voice.is_own else voice.leader or ""
        self._rooms.journal.plan(plan, author, now_s)
        was = () if before is None else before.members
        joined, dropped = sorted(set(plan.members) - set(was)), sorted(set(was) - set(plan.members))
        if joined or dropped:
            changes = [f"with {', '.join(joined)}"] * bool(joined) + [f"without {', '.join(dropped)}"] * bool(dropped)
            text = f"{author} plans for {len(plan.members)} of {len(self._configured)} pursuers, now {' and '.join(changes)}"
        elif before is not None and plan.term != before.term:
            text = f"{author} plans on in term {plan.term} for {len(plan.members)} of {len(self._configured)} pursuers"
        elif before is not None and around(plan) != around(before):
            text = f"{author} has exchanged sides: {', '.join(around(plan))} clockwise around the evader"
        else:
            return
        level = "warning" if dropped else "info"
        self._rooms.journal.event(
            level, "plan", text, term=plan.term, version=plan.version, members=list(plan.members), joined=joined, dropped=dropped
        )


def _ring_radius_m(rooms: Rooms) -> float:
    return CaptureRule(**rooms.mission.capture.model_dump()).slot_radius_m


def around(plan: Plan) -> tuple[str, ...]:
    """The vehicles clockwise around the evader, from the first by name on: it changes only when sides are exchanged."""
    clockwise = [seat.vehicle for seat in sorted(plan.seats, key=lambda seat: seat.bearing_rad)]
    first = clockwise.index(min(clockwise))
    return tuple(clockwise[first:] + clockwise[:first])
