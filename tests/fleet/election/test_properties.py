"""Whatever network, clocks and crashes do: one leader a term, one voice, terms that rise, and a leader once all is well."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from tests.fleet.election.ether import TIMING, Ether

LEADER_WITHIN_S = 3.0 * TIMING.timeout_max_s
RATES = st.sampled_from((1.0 - TIMING.clock_drift_max, 1.0, 1.0 + TIMING.clock_drift_max))
MEMBER = st.integers(0, 4)


class Storm(RuleBasedStateMachine):
    """Rules of `Ether` itself are asserted in every one of its steps."""

    @initialize(clocks=st.lists(st.tuples(RATES, st.floats(-1e6, 1e6)), min_size=1, max_size=5), seed=st.integers(0, 2**16))
    def begin(self, clocks: list[tuple[float, float]], seed: int) -> None:
        self.ether = Ether(tuple(rate for rate, _ in clocks), tuple(offset for _, offset in clocks), seed)
        self.ether.settle(LEADER_WITHIN_S)

    def name(self, index: int) -> str:
        return self.ether.names[index % len(self.ether.names)]

    @rule(duration_s=st.sampled_from((0.1, 0.4, 1.0, 3.0)), held_up=st.frozensets(MEMBER, max_size=2))
    def pass_time(self, duration_s: float, held_up: frozenset[int]) -> None:
        self.ether.pass_time(duration_s, frozenset(map(self.name, held_up)))

    @rule(
        loss=st.sampled_from((0.0, 0.3, 0.8)),
        delay_s=st.sampled_from(((0.0, 0.0), (0.0, 0.3), (0.2, 0.2), (0.0, 3.0))),
        repeats=st.sampled_from((0.0, 0.5)),
    )
    def change_the_weather(self, loss: float, delay_s: tuple[float, float], repeats: float) -> None:
        self.ether.loss, self.ether.delay_s, self.ether.repeats = loss, delay_s, repeats
        self.ether.pass_time(0.5)

    @rule(side=st.frozensets(MEMBER), one_way=st.booleans())
    def part(self, side: frozenset[int], one_way: bool) -> None:
        names = {self.name(index) for index in side}
        pairs = {(one, other) for one in names for other in self.ether.names if other not in names}
        self.ether.cut = pairs if one_way else pairs | {(other, one) for one, other in pairs}
        self.ether.pass_time(0.9)

    @rule(member=MEMBER, down_s=st.sampled_from((0.0, 0.04, 0.5)))
    def crash(self, member: int, down_s: float) -> None:
        self.ether.crash(self.name(member))
        self.ether.pass_time(down_s)

    @rule(member=MEMBER)
    def restart(self, member: int) -> None:
        if self.name(member) not in self.ether.alive:
            self.ether.restart(self.name(member))

    @rule()
    def heal(self) -> None:
        self.ether.make_whole()
        assert self.ether.settle(LEADER_WITHIN_S) <= LEADER_WITHIN_S, "a leader once the network is whole"


Storm.TestCase.settings = settings(
    max_examples=100, stateful_step_count=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
TestStorm = Storm.TestCase


def settled(members: int, seed: int = 0) -> Ether:
    ether = Ether((1.0,) * members, tuple(100.0 * index for index in range(members)), seed)
    ether.make_whole()
    ether.settle(LEADER_WITHIN_S)
    return ether


@pytest.mark.parametrize("members", [2, 3, 5, 10])
def test_a_healthy_leader_stays_and_a_member_that_comes_and_goes_does_not_depose_it(members: int) -> None:
    ether = settled(members)
    (leader,) = ether.voices()
    term = ether.alive[leader].term
    flapping = next(name for name in ether.names if name != leader)
    if members > 2:
        for _ in range(4):
            ether.cut = {pair for name in ether.names for pair in ((name, flapping), (flapping, name))}
            ether.pass_time(2.0)
            assert ether.voices() == [leader]
            ether.cut = set()
            ether.pass_time(0.4)
            ether.crash(flapping)
            ether.pass_time(0.4)
            ether.restart(flapping)
            ether.pass_time(0.4)
    ether.pass_time(5.0)
    assert ether.is_settled()
    assert (ether.voices(), ether.alive[leader].term) == ([leader], term)


def test_without_a_majority_nobody_leads_and_a_leader_that_returns_follows() -> None:
    ether = settled(5)
    (old,) = ether.voices()
    companion = next(name for name in ether.names if name != old)
    minority = {old, companion}
    pairs = {(one, other) for one in minority for other in ether.names if other not in minority}
    ether.cut = pairs | {(other, one) for one, other in pairs}
    ether.pass_time(4.0)
    (new,) = ether.voices()
    assert new not in minority
    assert not ether.alive[old].leader
    assert ether.alive[new].term > ether.alive[old].term
    ether.cut = set()
    ether.pass_time(1.0)
    assert ether.is_settled()
    assert ether.voices() == [new]
