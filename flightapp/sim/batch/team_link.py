"""What pursuers hear of one another: late, sometimes not at all, and always with its honest age."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from flightapp.core.types import TeamMember, VehicleState
from flightapp.sim.batch.noise import uniform
from flightapp.sim.batch.scenario import Scenario

EXTRAPOLATION_MAX_S = 0.5
"""As the application moves a teammate's last state to the present."""
FORGOTTEN_S = 10.0


class _Sent(NamedTuple):
    """What all pursuers sent in one control period."""

    states: list[VehicleState]
    modes: list[str]
    etas: list[float | None]
    alive: list[bool]


class TeamLink:
    """Between the pursuers of one episode. Before the start everyone has heard where everyone stands."""

    def __init__(self, scenario: Scenario, key: int) -> None:
        self._period_s = scenario.control_period_s
        self._count = scenario.pursuers.count
        self._names = [f"p{index + 1}" for index in range(self._count)]
        self._delay = math.ceil(scenario.messages.delay_s / self._period_s - 1e-9)
        self._loss = scenario.messages.loss_probability
        self._key = key
        self._messages = scenario.messages
        self._ideal = self._delay == 0 and self._loss == 0.0 and not scenario.failures and not self._messages.partitions
        self._sent: deque[_Sent] = deque(maxlen=self._delay + 1)
        self._heard: list[list[tuple[int, TeamMember]]] = []

    def teams(
        self, tick: int, states: list[VehicleState], modes: list[str], etas: list[float | None], alive: list[bool]
    ) -> list[tuple[TeamMember, ...]]:
        """Each pursuer's teammates at control period `tick`, in which `states` are true and sent; last, all that live, as they
        are. Who is not `alive` sends nothing.
        """
        members = [TeamMember(self._names[j], states[j], modes[j], etas[j], 0.0) for j in range(self._count)]
        everyone = tuple(members)
        if self._ideal:
            return [*(everyone[:i] + everyone[i + 1 :] for i in range(self._count)), everyone]
        self._transmit(tick, _Sent(states[: self._count], list(modes), list(etas), list(alive)))
        now_s = tick * self._period_s
        living = tuple(member for member, lives in zip(members, alive, strict=True) if lives)
        return [*(tuple(self._known(i, tick, now_s)) for i in range(self._count)), living]

    def _transmit(self, tick: int, sent: _Sent) -> None:
        if not self._heard:
            start, states, modes, etas = sent, sent.states, sent.modes, sent.etas
            self._sent.extend([start] * self._delay)
            first = [TeamMember(self._names[j], states[j], modes[j], etas[j], 0.0) for j in range(self._count)]
            self._heard = [[(-self._delay, member) for member in first] for _ in range(self._count)]
        self._sent.append(sent)
        arriving, sent_at, now_s = self._sent[0], tick - self._delay, tick * self._period_s
        for i in range(self._count):
            for j in range(self._count):
                if i == j or not arriving.alive[j] or self._messages.separates(now_s, i, j):
                    continue
                if uniform(self._key, sent_at + self._delay, i, j) >= self._loss:
                    member = TeamMember(self._names[j], arriving.states[j], arriving.modes[j], arriving.etas[j], 0.0)
                    self._heard[i][j] = (sent_at, member)

    def _known(self, i: int, tick: int, now_s: float) -> list[TeamMember]:
        members = []
        for j, (sent_at, member) in enumerate(self._heard[i]):
            age_s = (tick - sent_at) * self._period_s
            if j != i and age_s <= FORGOTTEN_S:
                state = member.state
                position = state.position_ned_m + min(age_s, EXTRAPOLATION_MAX_S) * state.velocity_ned_m_s
                moved = VehicleState(now_s, position, state.velocity_ned_m_s, state.yaw_rad)
                members.append(TeamMember(member.name, moved, member.mode, member.eta_s, age_s))
        return members
