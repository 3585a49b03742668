"""The leader's plan among simulated pursuers: the application's election and planning cores over a simulated bus.

Messages travel as late as all others and are lost as often; what is heard stays in force. Without an election the first pursuer
leads from the start, and when it fails nobody does. A pursuer that failed neither hears nor speaks.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from flightapp.core.types import Assignment, Limits, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.fleet.coordination.core import Coordinator, Voice
from flightapp.fleet.coordination.plan import Plan
from flightapp.fleet.coordination.scene import Scene, pursuer_of
from flightapp.fleet.coordination.sector_plan import SectorPlan
from flightapp.fleet.coordination.team_plan import TeamPlan
from flightapp.fleet.election.beacon import Beacon
from flightapp.fleet.election.core import Election
from flightapp.fleet.election.timing import Timing
from flightapp.planning.registry import make_team_plan
from flightapp.sim.batch.noise import uniform
from flightapp.sim.batch.scenario import Scenario

SILENT_S = 2.0
"""Of pursuers not heard for so long nothing is planned: as AC2F's `team_stale_s`."""

M = TypeVar("M")


@dataclass(slots=True)
class Bus(Generic[M]):
    """Messages of one kind on their way to every other pursuer."""

    count: int
    delay: int
    """In control periods."""
    loss: float
    key: int
    number: int
    """Of the kind: each kind is lost by its own draws."""
    separates: Callable[[int, int, int], bool] = lambda _tick, _i, _j: False
    """Whether pursuers i and j cannot hear one another at a control period."""
    _sent: deque[list[tuple[int, M]]] = field(init=False)

    def __post_init__(self) -> None:
        self._sent = deque([[] for _ in range(self.delay)], maxlen=self.delay + 1)

    def pass_on(self, tick: int, sent: list[tuple[int, M]]) -> list[list[tuple[int, M]]]:
        """What each hears at `tick`, (sender, message), while `sent` sets out."""
        self._sent.append(sent)
        arriving = self._sent[0]
        return [
            [(sender, message) for sender, message in arriving if sender != i and self._comes(tick, sender, i)]
            for i in range(self.count)
        ]

    def _comes(self, tick: int, sender: int, receiver: int) -> bool:
        if self.separates(tick, sender, receiver):
            return False
        return uniform(self.key, tick, sender, self.number * self.count + receiver) >= self.loss


class Assigning:
    """The cores of all pursuers, and what is on its way between them."""

    def __init__(
        self, scenario: Scenario, key: int, planner: str, given: Mapping[str, object], limits: Limits, plans: bool = True
    ) -> None:
        """given: the parameters of the strategy `planner`; plans: False, nothing is planned, only a leader elected."""
        self._is_planned = plans
        self._names = [f"p{index + 1}" for index in range(scenario.pursuers.count)]
        self._speed_m_s = scenario.pursuers.speed_max_m_s
        period_s, messages = scenario.control_period_s, scenario.messages
        delay = math.ceil(messages.delay_s / period_s - 1e-9)
        count = len(self._names)

        def separates(tick: int, i: int, j: int) -> bool:
            return messages.separates(tick * period_s, i, j)

        self._plans: Bus[Plan] = Bus(count, delay, messages.loss_probability, key, 1, separates)
        late = max(1, delay) - 1  # beacons set out a control period after they were spoken
        self._beacons: Bus[Beacon] = Bus(count, late, messages.loss_probability, key, 2, separates)
        team_plans: list[TeamPlan] = [
            make_team_plan(planner, limits=limits, parameters=given) or SectorPlan(scenario.capture.slot_radius_m)
            for _ in self._names
        ]
        self._cores = [Coordinator(team_plan) for team_plan in team_plans]
        self._elections: list[Election] = []
        if messages.election:
            timing = timing_for(max(1, delay) * period_s)
            self._elections = [
                Election(name, self._names, timing, 0.0, seed=key % 1000 + i) for i, name in enumerate(self._names)
            ]
        self._spoken: list[tuple[int, Beacon]] = []
        self._alive = [True] * count
        self._now_s = 0.0

    @property
    def leader(self) -> int | None:
        """Who leads now, of those that live; None: nobody."""
        if not self._elections:
            return 0 if self._alive[0] else None
        leads = (i for i, election in enumerate(self._elections) if self._alive[i] and election.is_leader(self._now_s))
        return next(leads, None)

    def assignments(
        self,
        tick: int,
        states: list[VehicleState],
        teams: list[tuple[TeamMember, ...]],
        target: TargetTrack | None,
        seen: list[ObstacleSet],
        alive: list[bool],
    ) -> list[Assignment | None]:
        """Of every pursuer at control period `tick`, each from what it knows itself; None for those not `alive`."""
        self._now_s, self._alive = states[0].t_s, list(alive)
        self._elect(tick)
        if not self._is_planned:
            return [None] * len(self._cores)
        sent: list[tuple[int, Plan]] = []
        for i, core in enumerate(self._cores):
            if alive[i] and (i == 0 or self._elections):
                scene = self._scene(i, states[i], teams[i], target, seen[i])
                sent.extend((i, plan) for plan in core.step(self._now_s, self._voice(i), scene, ()))
        heard = self._plans.pass_on(tick, sent)
        for i, core in enumerate(self._cores):
            if alive[i] and heard[i]:
                core.step(self._now_s, self._voice(i), None, [(self._names[sender], plan) for sender, plan in heard[i]])
        return [
            core.assignment(name) if lives else None for core, name, lives in zip(self._cores, self._names, alive, strict=True)
        ]

    def _elect(self, tick: int) -> None:
        if not self._elections:
            return
        heard = self._beacons.pass_on(tick, self._spoken)
        self._spoken = []
        for i, election in enumerate(self._elections):
            if self._alive[i]:
                inbox = [(self._names[sender], beacon) for sender, beacon in heard[i]]
                self._spoken.extend((i, beacon) for beacon in election.step(self._now_s, inbox))

    def _voice(self, i: int) -> Voice:
        if not self._elections:
            return Voice(self._names[0], 1, is_own=i == 0)
        election = self._elections[i]
        return Voice(election.leader, election.term, election.is_leader(self._now_s))

    def _scene(
        self, i: int, own: VehicleState, team: tuple[TeamMember, ...], target: TargetTrack | None, obstacles: ObstacleSet
    ) -> Scene | None:
        if target is None:
            return None
        heard = ((member.name, member.state) for member in team if member.age_s <= SILENT_S)
        places = sorted([(self._names[i], own), *heard], key=lambda place: self._names.index(place[0]))
        pursuers = tuple(pursuer_of(name, state, self._speed_m_s) for name, state in places)
        north, east, _ = target.position_ned_m.tolist()
        v_north, v_east, _ = target.velocity_ned_m_s.tolist()
        return Scene(north, east, v_north, v_east, pursuers, obstacles.discs)


def timing_for(way_s: float) -> Timing:
    """The election's durations where a message takes `way_s`: the application's own, stretched: a lease outlasts answers."""
    plain = Timing()
    stretch = max(1.0, way_s / plain.beacon_period_s)
    return Timing(
        stretch * plain.beacon_period_s, stretch * plain.lease_s, stretch * plain.timeout_min_s, stretch * plain.timeout_max_s
    )
