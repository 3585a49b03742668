"""Short flights under the whole planner, its commands followed at once: limits, mirror images, who gives way, and bad places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import (
    Assignment,
    Decision,
    Limits,
    Observation,
    ObstacleSet,
    Rendezvous,
    TargetTrack,
    TeamMember,
    VehicleState,
)
from flightapp.planning import make_planner
from flightapp.planning.api import Planner
from tests.planning.hunting.test_planner import FACTS, LIMITS, LINE, RING, Place, hunter, seen

DT_S = 0.1
Disc = tuple[float, float, float]
places = st.tuples(st.floats(-25, 25), st.floats(-25, 25))
obstacles = st.lists(st.tuples(st.floats(-15, 25), st.floats(-20, 20), st.floats(0.3, 1.5)), max_size=5)


class Flown:
    """One vehicle that does what its planner says."""

    def __init__(self, planner: Planner, place: Place, yaw_rad: float = 0.0) -> None:
        self.planner, self.place, self.yaw_rad = planner, np.array((*place, -5.0)), yaw_rad
        self.velocity = np.zeros(3)
        self.decisions: list[Decision] = []

    def state(self, t_s: float) -> VehicleState:
        return VehicleState(t_s, self.place.copy(), self.velocity.copy(), self.yaw_rad)

    def decide(
        self,
        t_s: float,
        target: TargetTrack,
        team: Sequence[TeamMember] = (),
        discs: Sequence[Disc] = (),
        told: Assignment | None = None,
    ) -> None:
        rows = np.array([(n, e, r, 0.0, 0.0, -np.inf, np.inf) for n, e, r in discs]).reshape(-1, 7)
        around = ObstacleSet(t_s, rows, np.zeros((0, 2)))
        self.decisions.append(self.planner.step(Observation(t_s, DT_S, self.state(t_s), tuple(team), target, around, LINE, told)))

    def move(self) -> None:
        self.velocity, self.yaw_rad = self.decisions[-1].velocity_ned_m_s, self.decisions[-1].yaw_rad
        self.place = self.place + DT_S * self.velocity


def target_at(t_s: float, place: Place, velocity: Place = (0.0, 0.0)) -> TargetTrack:
    n, e = place[0] + velocity[0] * t_s, place[1] + velocity[1] * t_s
    return TargetTrack(t_s, np.array((n, e, -5.0)), np.array((*velocity, 0.0)), np.eye(6), 0.0)


def free_of(discs: Sequence[Disc], place: Place) -> list[Disc]:
    return [(n, e, r) for n, e, r in discs if math.dist((n, e), place) > r + 1.0]


@pytest.mark.parametrize("name", ["hunting", "dwa"])
@settings(max_examples=8, deadline=None)
@given(target=places.filter(lambda place: math.hypot(*place) > 10.0), discs=obstacles)
def test_every_command_can_be_flown_within_a_control_period(name: str, target: Place, discs: list[Disc]) -> None:
    """But for leaving an obstacle's margin, which comes before everything: that is not provoked here."""
    one = Flown(hunter(name), (0.0, 0.0))
    for tick in range(25):
        before, course = float(np.hypot(*one.velocity[:2])), math.atan2(one.velocity[1], one.velocity[0])
        one.decide(DT_S * tick, target_at(DT_S * tick, target, (0.5, -0.5)), discs=free_of(discs, (0.0, 0.0)))
        one.move()
        after = float(np.hypot(*one.velocity[:2]))
        assert abs(after - before) <= LIMITS.acceleration_max_m_s2 * DT_S + 1e-6
        if min(before, after) > 0.05:
            turn = abs(math.remainder(math.atan2(one.velocity[1], one.velocity[0]) - course, 2.0 * math.pi))
            assert turn <= LIMITS.yaw_rate_max_rad_s * DT_S + 1e-6


@settings(max_examples=8, deadline=None)
@given(target=st.tuples(st.floats(10, 25), st.floats(3, 20)), discs=obstacles, heading=st.floats(0.1, 0.4))
def test_without_the_right_hand_rule_a_mirrored_scene_is_flown_as_the_mirror_image(
    target: Place, discs: list[Disc], heading: float
) -> None:
    """Guidance is off, too: a random tree has no mirror image."""
    free = free_of(discs, (0.0, 0.0))
    there, mirrored = (Flown(hunter(right_hand=False, guidance=False), (0.0, 0.0), sign * heading) for sign in (1.0, -1.0))
    for tick in range(8):
        t_s = DT_S * tick
        there.decide(t_s, target_at(t_s, target), discs=free)
        mirrored.decide(t_s, target_at(t_s, (target[0], -target[1])), discs=[(n, -e, r) for n, e, r in free])
        there.move()
        mirrored.move()
        assert mirrored.velocity[:2].tolist() == pytest.approx([there.velocity[0], -there.velocity[1]], abs=1e-6)


def head_on(right_hand: bool) -> tuple[list[float], float]:
    """East offset of the one that flies north over the other's as they pass, and their least distance."""
    limits = Limits(2.0, 1.0, 60.0, 1.0, 2.0, 2.0, 0.5, 0.25)
    given = {**FACTS, **RING, "separation_m": 1.0, "right_hand": right_hand, "guidance": False}
    pair = [
        Flown(make_planner("hunting", limits=limits, parameters=given, seed=k), (40.0 * k, 0.0), math.pi * k) for k in range(2)
    ]
    told = [Assignment(0.0, 99.0, Rendezvous(60.0 - 80.0 * k, 0.0, -0.5 * math.pi, 3.0, 5, 0, closing=False)) for k in range(2)]
    beside, least = [], math.inf
    for tick in range(200):
        t_s = DT_S * tick
        states = [one.state(t_s) for one in pair]
        for k, one in enumerate(pair):
            mate = TeamMember(f"p{2 - k}", states[1 - k], "approach", None, 0.0)
            one.decide(t_s, target_at(t_s, (20.0, 400.0), (0.0, -1.0)), (mate,), told=told[k])
        for one in pair:
            one.move()
        north, south = pair
        least = min(least, math.dist(north.place, south.place))
        if abs(north.place[0] - south.place[0]) < 1.0:
            beside.append(float(north.place[1] - south.place[1]))
    return beside, least


def test_two_head_on_pass_port_to_port_and_never_touch() -> None:
    beside, least = head_on(right_hand=True)
    assert least > 2.0 * 0.5
    assert beside
    assert min(beside) > 0.0, "the one that flies north passes east of the other"


def test_on_top_of_the_target_it_flies_out_to_its_slot() -> None:
    one = Flown(hunter(), (0.0, 0.0))
    mates = [
        TeamMember(f"p{k + 2}", VehicleState(0.0, np.array((-1.5, e, -5.0)), np.zeros(3), 0.0), "enclose", None, 0.0)
        for k, e in enumerate((2.6, -2.6))
    ]
    for tick in range(60):
        one.decide(DT_S * tick, target_at(DT_S * tick, (0.0, 0.0)), mates)
        one.move()
    assert math.hypot(*one.place[:2]) == pytest.approx(3.0, abs=0.5)


def test_inside_the_zone_of_a_mate_it_leaves_outwards_before_anything_else() -> None:
    decision = hunter(separation_m=2.0).step(seen((0.0, 0.4), (-30.0, 0.0), ((0.0, 0.0),)))
    assert decision.velocity_ned_m_s[:2].tolist() == pytest.approx([0.0, 0.3 * LIMITS.speed_max_m_s])


def test_shut_in_it_says_that_no_way_was_found_and_touches_nothing() -> None:
    wall = [(5.0 * math.cos(a), 5.0 * math.sin(a), 0.8) for a in np.arange(0.0, 6.28, 0.25)]
    one = Flown(hunter(guidance_nodes=100, stall_progress_s=0.5), (0.0, 0.0))
    for tick in range(70):
        one.decide(DT_S * tick, target_at(DT_S * tick, (30.0, 0.0)), discs=wall)
        one.move()
        assert min(math.dist(one.place[:2], disc[:2]) - disc[2] for disc in wall) > LIMITS.body_radius_m
    assert one.decisions[-1].diagnostics["flags"] == ["degraded", "blocked"]
    assert any("blocked" in decision.reason for decision in one.decisions)


def test_a_target_that_never_moved_is_met_from_where_the_team_comes() -> None:
    decision = hunter().step(seen((0.0, 0.0), (40.0, 0.0), ((0.0, 8.0), (0.0, -8.0))))
    assert decision.diagnostics["base_point"] == pytest.approx([40.0, 0.0], abs=0.5)
    far = hunter().step(seen((0.0, 0.0), (0.0, 40.0), ((8.0, 0.0), (-8.0, 0.0))))
    north, east = decision.goal_ned_m[:2].tolist()  # type: ignore[index]
    other_north, other_east = far.goal_ned_m[:2].tolist()  # type: ignore[index]
    assert math.hypot(north - 40.0, east) == pytest.approx(3.0, abs=0.3)
    assert (other_east - 40.0, abs(other_north)) == pytest.approx((north - 40.0, abs(east)), abs=0.3), "turned with the team"


def test_a_vehicle_that_stands_before_a_tree_turns_away_as_fast_as_its_autopilot_can() -> None:
    """An autopilot turns the nose in proportion to how far the setpoint is ahead of it: by one that never is, hardly at all."""
    period_s, tree = 0.04, (14.0, 10.0, 0.8)
    limits = replace(LIMITS, yaw_rate_max_rad_s=0.785, yaw_acceleration_max_rad_s2=2.0)
    facts = {"reaction_s": 0.2, "response_lag_s": 0.45, "command_blend": 0.08, "control_period_s": period_s}
    given = {**FACTS, **RING, "separation_m": 2.0, **facts}
    one = Flown(make_planner("hunting", limits=limits, parameters=given, seed=5), (12.14, 10.25), 0.3)
    for tick in range(100):
        t_s = period_s * tick
        one.decide(t_s, target_at(t_s, (-40.0, -5.0)), discs=[tree])
        wanted = one.decisions[-1]
        one.velocity = one.velocity + (wanted.velocity_ned_m_s - one.velocity) * period_s / 0.45
        turn = math.remainder(wanted.yaw_rad - one.yaw_rad, 2.0 * math.pi)
        one.yaw_rad += min(0.785, max(-0.785, 2.0 * turn)) * period_s
        one.place = one.place + period_s * one.velocity
        assert math.dist(one.place[:2], tree[:2]) > tree[2] + LIMITS.body_radius_m
    assert one.place[0] < 5.0, "half a turn, and away, within 4 s"


@pytest.mark.parametrize("shut", [False, True])
def test_out_of_the_zone_of_a_mate_it_does_not_fly_into_an_obstacle(shut: bool) -> None:
    """Straight out there is a tree; aside there is room, or none where it is shut in."""
    trees = [
        (0.0, 1.6, 0.5),
        *([(1.4 * math.cos(a), 0.4 + 1.4 * math.sin(a), 0.5) for a in np.arange(-0.4, 3.6, 0.4)] if shut else []),
    ]
    one = Flown(hunter(separation_m=2.0), (0.0, 0.4))
    mate = TeamMember("p2", VehicleState(0.0, np.array((0.0, 0.0, -5.0)), np.zeros(3), 0.0), "approach", None, 0.0)
    for tick in range(30):
        one.decide(DT_S * tick, target_at(DT_S * tick, (-30.0, 0.0)), (mate,), discs=trees)
        one.move()
        assert min(math.dist(one.place[:2], tree[:2]) - tree[2] for tree in trees) > LIMITS.body_radius_m
    assert shut or math.dist(one.place[:2], (0.0, 0.0)) > 1.0
