"""Planning by the one that leads, and obeying by the others: `step(now_s, ...)` takes plans in and gives plans out.

The leader plans every `TeamPlan.period_s` and sends every plan: a lost one is replaced by the next, and who joins needs no
history. Only the leader that is followed, in its own term, is believed; of its plans the newest. Without a leader the last plan
stays, unless the team plan says how long it may; and the first plan of a new leader goes on from the last one's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from flightapp.core.types import Assignment
from flightapp.fleet.coordination.plan import Plan, assignment_of
from flightapp.fleet.coordination.scene import Scene
from flightapp.fleet.coordination.team_plan import TeamPlan

SLACK_S = 1e-3
JOIN_S = 1.0
"""How long a newcomer has taken part before it gets a seat: who comes and goes would turn the others' seats each time."""


@dataclass(frozen=True, slots=True)
class Voice:
    """The election as this vehicle knows it."""

    leader: str | None
    term: int
    is_own: bool
    """This vehicle leads, and may decide now."""


class Coordinator:
    """One vehicle's part. `plan` is the one in force here; None before the first."""

    def __init__(self, team_plan: TeamPlan) -> None:
        self._team_plan = team_plan
        self._due_s = -math.inf
        self._there_since_s: dict[str, float] = {}
        self._leaderless_since_s: float | None = None
        self._is_deserted = False
        self.plan: Plan | None = None
        self.refused = 0
        """Plans from who does not lead, or older than the one in force."""

    def step(self, now_s: float, voice: Voice, scene: Scene | None, inbox: Iterable[tuple[str, Plan]]) -> list[Plan]:
        """Take what was heard; the plan to send, if this vehicle leads and one is due. scene: None if the evader is unknown."""
        self._note(now_s, voice, scene)
        for sender, plan in inbox:
            self._hear(voice, sender, plan)
        if not voice.is_own or scene is None or now_s < self._due_s - SLACK_S:
            return []
        members = self._members(now_s, scene)
        if not members.pursuers:
            return []
        self._due_s = now_s + self._team_plan.period_s
        self.plan = self._planned(now_s, voice.term, members)
        return [self.plan]

    def assignment(self, vehicle: str) -> Assignment | None:
        """The part of `vehicle` in the plan in force; None without one, or once it counts no more for want of a leader."""
        return None if self.plan is None or self._is_deserted else assignment_of(self.plan, vehicle)

    def _hear(self, voice: Voice, sender: str, plan: Plan) -> None:
        is_newer = self.plan is None or plan.rank > self.plan.rank
        if voice.is_own or sender != voice.leader or plan.term != voice.term or not is_newer:
            self.refused += 1
            return
        self.plan = plan

    def _note(self, now_s: float, voice: Voice, scene: Scene | None) -> None:
        if voice.leader is not None:
            self._leaderless_since_s = None
        elif self._leaderless_since_s is None:
            self._leaderless_since_s = now_s
        since_s = self._leaderless_since_s
        self._is_deserted = since_s is not None and now_s - since_s > self._team_plan.leaderless_s
        if scene is not None:
            here = {pursuer.name for pursuer in scene.pursuers}
            self._there_since_s = {name: self._there_since_s.get(name, now_s) for name in here}
            self._team_plan.note(now_s, scene)

    def _members(self, now_s: float, scene: Scene) -> Scene:
        """`scene` with those only that get a seat: who goes is out at once."""
        if self.plan is None:
            return scene
        seated = self.plan.members

        def stays(name: str) -> bool:
            return name in seated or now_s - self._there_since_s[name] >= JOIN_S - SLACK_S

        return replace(scene, pursuers=tuple(pursuer for pursuer in scene.pursuers if stays(pursuer.name)))

    def _planned(self, now_s: float, term: int, scene: Scene) -> Plan:
        draft = self._team_plan.draft(now_s, scene, self.plan)
        version = self.plan.version + 1 if self.plan is not None and self.plan.term == term else 1
        return Plan(term, version, draft.seats, draft.meeting)
