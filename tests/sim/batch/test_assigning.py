"""The leader among simulated pursuers: elected over a lossy bus, replaced when it fails, and what its team plans by."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from flightapp.core.types import Decision, Observation, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.planning.registry import UNLED
from flightapp.sim.batch.assigning import Assigning, Bus, timing_for
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.facts import planner_parameters
from flightapp.sim.batch.scenario import FAMILIES, Scenario, load_scenario

PERIOD_S = 0.1
HUNTING = Path(__file__).parents[3] / "missions" / "scenarios" / "hunting-1-free.toml"
NOTHING = ObstacleSet(0.0, np.zeros((0, 7)), np.zeros((0, 2)))


def scenario_of(*, election: bool, loss: float = 0.0, delay_s: float = 0.0) -> Scenario:
    return FAMILIES["dense"].model_validate(
        {
            "name": "five",
            "family": "dense",
            "time_limit_s": 30.0,
            "pursuers": {"count": 5, "speed_max_m_s": 6.0},
            "evader": {"policy": "straight", "speed_max_m_s": 2.0},
            "capture": {"radius_m": 4.0, "hold_radius_m": 3.0},
            "messages": {"assignment": True, "election": election, "loss_probability": loss, "delay_s": delay_s},
        }
    )


class Flight:
    """Five that stand in a row; the target comes towards them."""

    def __init__(self, scenario: Scenario, planner: str = "hunting") -> None:
        given = planner_parameters(scenario, planner)
        self.assigning = Assigning(scenario, 11, planner, given, scenario.pursuers.limits())
        self.tick, self.alive = 0, [True] * 5

    def fly(self, seconds: float) -> list[object]:
        got: list[object] = []
        for _ in range(round(seconds / PERIOD_S)):
            t_s = self.tick * PERIOD_S
            states = [VehicleState(t_s, np.array([0.0, 10.0 * i, -5.0]), np.zeros(3), 0.0) for i in range(5)]
            members = [TeamMember(f"p{i + 1}", states[i], "approach", None, 0.0 if self.alive[i] else 9.0) for i in range(5)]
            teams = [tuple(members[:i] + members[i + 1 :]) for i in range(5)]
            target = TargetTrack(t_s, np.array([60.0 - 2.0 * t_s, 20.0, -5.0]), np.array([-2.0, 0.0, 0.0]), np.eye(6), 0.0)
            got = list(self.assigning.assignments(self.tick, states, teams, target, [NOTHING] * 5, self.alive))
            self.tick += 1
        return got


def slots_of(assigned: list[object]) -> list[int]:
    return sorted(one.rendezvous.slot for one in assigned if one is not None)  # type: ignore[attr-defined]


def test_a_leader_is_elected_and_gives_everybody_a_slot_of_one_plan() -> None:
    flight = Flight(scenario_of(election=True, loss=0.1, delay_s=0.1))
    assert flight.assigning.leader is None
    got = flight.fly(6.0)
    assert flight.assigning.leader is not None
    assert slots_of(got) == [0, 1, 2, 3, 4]


def test_when_the_leader_and_another_fail_the_three_left_get_a_plan_of_their_own() -> None:
    flight = Flight(scenario_of(election=True))
    flight.fly(4.0)
    first = flight.assigning.leader
    assert first is not None
    flight.alive[first] = flight.alive[(first + 1) % 5] = False
    assert slots_of(flight.fly(0.3)) != [0, 1, 2]
    got = flight.fly(5.0)
    assert flight.assigning.leader not in (None, first)
    assert slots_of(got) == [0, 1, 2]
    assert [one is None for one in got] == [not lives for lives in flight.alive]


def test_three_of_five_dead_nobody_leads_and_after_a_while_everybody_plans_alone() -> None:
    flight = Flight(scenario_of(election=True))
    flight.fly(4.0)
    for index in range(3):
        flight.alive[index] = False
    assert flight.fly(8.0) == [None] * 5
    assert flight.assigning.leader is None


def test_without_an_election_the_first_leads_and_its_last_plan_stays_when_it_is_gone() -> None:
    flight = Flight(scenario_of(election=False))
    assert flight.assigning.leader == 0
    assert slots_of(flight.fly(1.0)) == [0, 1, 2, 3, 4]
    flight.alive[0] = False
    got = flight.fly(8.0)
    assert flight.assigning.leader is None
    assert len(slots_of(got)) == 4


def test_strategies_without_a_plan_of_their_own_get_sectors() -> None:
    got = Flight(scenario_of(election=False), "ac2f").fly(1.0)
    assert all(one is not None and one.rendezvous is None for one in got)  # type: ignore[attr-defined]


def test_the_bus_delays_and_loses_as_it_is_told() -> None:
    bus: Bus[str] = Bus(2, 2, 0.0, 5, 1)
    assert bus.pass_on(0, [(0, "a")]) == [[], []]
    assert bus.pass_on(1, []) == [[], []]
    assert bus.pass_on(2, []) == [[], [(0, "a")]]
    lossy: Bus[str] = Bus(2, 0, 0.3, 5, 1)
    heard = sum(len(lossy.pass_on(tick, [(0, "a")])[1]) for tick in range(1000))
    assert 630 < heard < 770


class Onlooker:
    """Keeps who was given a part of a plan."""

    def __init__(self) -> None:
        self.led = 0

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        self.led += sum(observation.assignment is not None for observation in observations)

    def end(self, truth: Truth) -> None:
        pass


@pytest.mark.parametrize("planner", sorted(UNLED))
def test_where_nobody_looks_on_no_plan_is_made_for_who_takes_no_notice_of_it(planner: str) -> None:
    scenario = load_scenario(HUNTING, {"time_limit_s": "20.0"})
    onlooker = Onlooker()
    with_plan, without = fly(scenario, planner, 3, watcher=onlooker), fly(scenario, planner, 3)
    assert onlooker.led == 5 * 40
    for field in dataclasses.fields(with_plan):
        if field.name not in ("decision_ns", "sim_wall_ns"):
            assert getattr(with_plan, field.name) == getattr(without, field.name), field.name


def test_a_leader_that_fails_is_replaced_within_two_of_the_elections_longest_timeouts() -> None:
    flight = Flight(scenario_of(election=True))
    flight.fly(4.0)
    first = flight.assigning.leader
    assert first is not None
    flight.alive[first] = False
    flight.fly(2.0 * timing_for(PERIOD_S).timeout_max_s)
    assert flight.assigning.leader not in (None, first)
