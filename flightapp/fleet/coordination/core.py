"""Planning by the one that leads, and obeying by the others: `step(now_s, ...)` takes plans in and gives plans out.

The leader plans five times a second and sends every plan: a lost one is replaced by the next, and who joins needs no history.
Only the leader that is followed, in its own term, is believed; of its plans the newest. Without a leader nothing changes.
Seats are exchanged only for a gain that is worth it, and the first plan of a new leader goes on from the last one's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from flightapp.fleet.coordination.plan import Plan, Seat
from flightapp.fleet.coordination.scene import Scene
from flightapp.fleet.coordination.sectors import Division, divide, kept_bearings, turned

PLAN_PERIOD_S = 0.2
SLACK_S = 1e-3
EXCHANGE_GAIN_S = 0.5
EXCHANGE_GAIN_SHARE = 0.1
"""Of the cost: seats are exchanged for a gain above both."""
ARRIVAL_MAX_S = 120.0
"""What is said of a chase that hardly ever ends: an evader as fast as the pursuers is met after hours, or never."""
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

    def __init__(self, ring_radius_m: float) -> None:
        self._ring_radius_m = ring_radius_m
        self._due_s = -float("inf")
        self._there_since_s: dict[str, float] = {}
        self.plan: Plan | None = None
        self.refused = 0
        """Plans from who does not lead, or older than the one in force."""

    def step(self, now_s: float, voice: Voice, scene: Scene | None, inbox: Iterable[tuple[str, Plan]]) -> list[Plan]:
        """Take what was heard; the plan to send, if this vehicle leads and one is due. scene: None if the evader is unknown."""
        self._note_presence(now_s, scene)
        for sender, plan in inbox:
            self._hear(voice, sender, plan)
        if not voice.is_own or scene is None or now_s < self._due_s - SLACK_S:
            return []
        members = self._members(now_s, scene)
        if not members.pursuers:
            return []
        self._due_s = now_s + PLAN_PERIOD_S
        self.plan = self._planned(now_s, voice.term, members)
        return [self.plan]

    def _hear(self, voice: Voice, sender: str, plan: Plan) -> None:
        is_newer = self.plan is None or plan.rank > self.plan.rank
        if voice.is_own or sender != voice.leader or plan.term != voice.term or not is_newer:
            self.refused += 1
            return
        self.plan = plan

    def _note_presence(self, now_s: float, scene: Scene | None) -> None:
        if scene is not None:
            here = {pursuer.name for pursuer in scene.pursuers}
            self._there_since_s = {name: self._there_since_s.get(name, now_s) for name in here}

    def _members(self, now_s: float, scene: Scene) -> Scene:
        """`scene` with those only that get a seat: who goes is out at once."""
        if self.plan is None:
            return scene
        seated = self.plan.members

        def stays(name: str) -> bool:
            return name in seated or now_s - self._there_since_s[name] >= JOIN_S - SLACK_S

        return replace(scene, pursuers=tuple(pursuer for pursuer in scene.pursuers if stays(pursuer.name)))

    def _planned(self, now_s: float, term: int, scene: Scene) -> Plan:
        division = self._division(scene)
        version = self.plan.version + 1 if self.plan is not None and self.plan.term == term else 1
        return Plan(term, version, tuple(_seats(now_s, scene, self._ring_radius_m, division)))

    def _division(self, scene: Scene) -> Division:
        """The one in force, turned with the pursuers, as long as another is not worth the exchange."""
        best = divide(scene, self._ring_radius_m)
        before = {} if self.plan is None else {seat.vehicle: seat.bearing_rad for seat in self.plan.seats}
        bearings = kept_bearings(scene, before)
        if bearings is None:
            return best
        kept = turned(scene, self._ring_radius_m, bearings)
        gain_s = kept.cost_s - best.cost_s
        return best if gain_s > max(EXCHANGE_GAIN_S, EXCHANGE_GAIN_SHARE * kept.cost_s) else kept


def _seats(now_s: float, scene: Scene, radius_m: float, division: Division) -> Iterable[Seat]:
    for pursuer, bearing, after in zip(scene.pursuers, division.bearings_rad, division.arrivals_s, strict=True):
        after_s = min(float(after), ARRIVAL_MAX_S)
        north = scene.north_m + scene.v_north_m_s * after_s + radius_m * math.cos(bearing)
        east = scene.east_m + scene.v_east_m_s * after_s + radius_m * math.sin(bearing)
        yield Seat(pursuer.name, float(bearing), north, east, now_s + after_s)
