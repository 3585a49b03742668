"""The whole supervisor: whatever it is told it answers, within the limits; and guards that act at once do not fight."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clearance import clearance_m
from flightapp.core.types import Limits, ObstacleSet, Setpoint, TargetTrack, TeamMember, VehicleState
from flightapp.safety.api import Action, SafetyContext
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.supervisor import Supervisor, make_supervisor
from tests.safety.closed_loop import (
    LIMITS,
    PARAMETERS,
    PERIOD_S,
    Body,
    context_of,
    discs_at,
    member_of,
    noisy,
    random_wishes,
    setpoint_of,
    target_at,
    towards,
)

ROOT = Path(__file__).parents[2]
MISSION = load_mission(ROOT / "missions" / "demo_two_pursuers.toml")
PROFILE = load_profile(ROOT / "profiles" / "sim.toml")

anything = st.one_of(st.floats(), st.floats(-40, 40), st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1e300, 1e-300]))
three = st.tuples(anything, anything, anything).map(np.array)
states = st.builds(VehicleState, anything, three, three, anything)
members = st.builds(TeamMember, st.sampled_from(["p1", "p2", "e1", "nobody"]), states, st.just("PURSUE"), st.none(), anything)
tracks = st.builds(TargetTrack, anything, three, three, st.just(np.eye(6)), anything)
discs = st.lists(st.tuples(*[anything] * 7), max_size=4).map(lambda rows: np.array(rows, dtype=float).reshape(-1, 7))
sectors = st.lists(st.tuples(anything, anything), max_size=3).map(lambda rows: np.array(rows, dtype=float).reshape(-1, 2))
obstacles = st.builds(ObstacleSet, anything, discs, sectors)
setpoints = st.builds(Setpoint, three, anything, st.one_of(st.none(), three))
contexts = st.builds(
    SafetyContext,
    anything,
    anything,
    st.sampled_from(["p1", "p2"]),
    states,
    anything,
    st.lists(members, max_size=3).map(tuple),
    st.one_of(st.none(), tracks),
    obstacles,
    anything,
    st.one_of(st.none(), setpoints),
    st.just(LIMITS),
    st.one_of(st.none(), anything),
    st.one_of(st.none(), anything),
)
sane = st.builds(VehicleState, st.floats(0, 9), three, three, st.just(0.0)).map(
    lambda state: VehicleState(1.0, np.clip(np.nan_to_num(state.position_ned_m), -90, 90), np.zeros(3), 0.0)
)


def _supervisor(name: str = "p1") -> Supervisor:
    return make_supervisor(MISSION, PROFILE, name)


def _is_within_limits(setpoint: Setpoint) -> bool:
    north, east, down = setpoint.velocity_ned_m_s.tolist()
    numbers = [north, east, down, setpoint.yaw_rad]
    if setpoint.acceleration_ned_m_s2 is not None:
        numbers += setpoint.acceleration_ned_m_s2.tolist()
    return (
        all(map(math.isfinite, numbers))
        and math.hypot(north, east) <= LIMITS.speed_max_m_s + 1e-6
        and abs(down) <= LIMITS.climb_rate_max_m_s + 1e-9
    )


@settings(max_examples=300, deadline=None)
@given(setpoints, contexts, st.lists(setpoints, max_size=2), st.one_of(st.none(), sane))
def test_whatever_it_is_told_the_answer_is_finite_and_within_limits(
    setpoint: Setpoint, context: SafetyContext, more: list[Setpoint], own: VehicleState | None
) -> None:
    if own is not None:  # Most contexts have no own state to judge by; here the guards behind that gate are reached.
        context = dataclasses.replace(context, own=own, own_age_s=0.02, dt_s=PERIOD_S)
    supervisor = _supervisor()
    for wish in [setpoint, *more]:
        supervised = supervisor.check(wish, context)
        assert _is_within_limits(supervised.setpoint)
        assert all(isinstance(text, str) and text for pair in supervised.acting for text in pair)
        assert not any(name == "supervisor" for name, _ in supervised.acting), supervised.acting
        if supervised.demand is not None:
            assert supervised.demand.guard in dict(supervised.acting)


@pytest.mark.parametrize(
    "broken",
    [
        {"own": VehicleState(0.0, np.zeros(2), np.zeros(1), 0.0)},
        {"obstacles": ObstacleSet(0.0, np.zeros((3, 2)), np.zeros(4))},
        {"previous": Setpoint(np.zeros(1), math.nan)},
        {"team": (None,)},
        {"limits": Limits(5.0, math.nan, 0.0, 0.0, 0.0, 2.0, 0.35, 0.45)},
        {"obstacles": None, "previous": None, "own": None},
    ],
    ids=["own state", "obstacles", "previous", "team", "limits", "nothing"],
)
def test_what_is_not_even_of_the_right_shape_ends_standing(broken: dict[str, object]) -> None:
    context = dataclasses.replace(context_of(Body("p1", (10.0, 0.0))), **broken)
    supervised = _supervisor().check(setpoint_of(3.0, 1.0), context)
    assert _is_within_limits(supervised.setpoint)
    if "supervisor" in dict(supervised.acting):
        assert not supervised.setpoint.velocity_ned_m_s.any()
        assert supervised.demand is not None
        assert supervised.demand.action == Action.HOLD


def test_a_guard_that_raises_stands_the_vehicle_and_says_so() -> None:
    class Broken:
        name = "broken"

        def check(self, setpoint: Setpoint, context: SafetyContext) -> None:
            raise ZeroDivisionError("one over nothing")

    body = Body("p1", (0.0, 0.0))
    body.previous = setpoint_of(1.0, 0.0, 0.0, 0.4)
    supervisor = Supervisor(stops=(FiniteGuard(),), limits=(Broken(),), spatial=(), rates=(), finals=())
    supervised = supervisor.check(setpoint_of(3.0, 0.0), context_of(body))
    assert supervised.setpoint.velocity_ned_m_s.tolist() == [0.0, 0.0, 0.0]
    assert supervised.setpoint.yaw_rad == 0.4
    assert supervised.acting == (("supervisor", "a guard failed, ZeroDivisionError: one over nothing: standing still"),)


def test_a_planner_s_nan_beyond_the_fence_still_goes_back() -> None:
    body = Body("p1", (67.0, 0.0))
    supervised = _supervisor().check(setpoint_of(math.nan, 0.0), context_of(body))
    assert supervised.setpoint.velocity_ned_m_s[0] < 0.0
    assert [name for name, _ in supervised.acting][:2] == ["finite", "geofence"]


def test_only_spatial_braking_exceeds_the_rate_limits() -> None:
    """Beside an obstacle that appears the step is larger than the acceleration allows; in the open it never is."""
    body = Body("p1", (10.0, 0.0), (0.0, 5.0, 0.0))
    body.previous = setpoint_of(0.0, 5.0)
    turned = _supervisor().check(setpoint_of(5.0, 0.0), context_of(body)).setpoint.velocity_ned_m_s
    assert np.hypot(*(turned[:2] - (0.0, max(0.0, turned[1])))) <= LIMITS.acceleration_max_m_s2 * PERIOD_S + 1e-6
    wall = discs_at((10.0, 1.2, 0.5))
    braked = _supervisor().check(setpoint_of(5.0, 0.0), context_of(body, discs=wall))
    assert "obstacle-stop" in dict(braked.acting)
    assert braked.setpoint.velocity_ned_m_s[1] < 2.0


FENCE = Polygon(MISSION.flight_volume.vertices_m)
corner = st.tuples(st.floats(45.0, 64.0), st.floats(12.0, 29.0))


class Corner:
    """Two pursuers, an evader, trees and the corner of the fence, all within braking distance of one another."""

    def __init__(
        self, starts: list[tuple[float, float]], tree: tuple[float, float], evader: tuple[float, float], seed: int
    ) -> None:
        self.trees = discs_at((*tree, 0.8), (55.0, 20.0, 0.5))
        self.evader = np.array([*evader, -5.0])
        self.bodies = [Body(name, start) for name, start in zip(("p1", "p2"), starts, strict=True)]
        self.wishes = [random_wishes(seed, hold_s=1.5), towards(evader)]

    def is_clear(self) -> bool:
        one, other = (body.position[:2] for body in self.bodies)
        apart = math.dist(one, other) > 2.2 and all(math.dist(place, self.evader[:2]) > 1.8 for place in (one, other))
        return apart and all(clearance_m(place, self.trees, LIMITS.body_radius_m) > 0.3 for place in (one, other))

    def fly(self, supervisors: list[Supervisor], seconds: float, seed: int) -> list[str]:
        """What was violated."""
        random, violated = np.random.default_rng(seed), set()
        for step in range(round(seconds / PERIOD_S)):
            t_s, sent = step * PERIOD_S, []
            for index, body in enumerate(self.bodies):
                other = self.bodies[1 - index]
                context = context_of(
                    body,
                    t_s,
                    team=(TeamMember(other.name, other.state(t_s), "", None, 0.02),),
                    target=target_at(self.evader, (0.0, 0.0, 0.0), 0.02),
                    discs=self.trees,
                )
                wish = Setpoint(self.wishes[(index + int(t_s / 2)) % 2](t_s, body), 0.0)
                sent.append(supervisors[index].check(wish, noisy(context, random, 0.02)).setpoint)
            for body, setpoint in zip(self.bodies, sent, strict=True):
                body.fly(setpoint)
                place = body.position[:2]
                if not FENCE.contains(Point(place)):
                    violated.add("fence")
                if clearance_m(place, self.trees, LIMITS.body_radius_m) <= 0.0:
                    violated.add("obstacle")
                if math.dist(place, self.evader[:2]) < PARAMETERS.target_keep_out_m - 0.05:
                    violated.add("keep-out")
            if math.dist(self.bodies[0].position[:2], self.bodies[1].position[:2]) < PARAMETERS.separation_min_m:
                violated.add("separation")
        return sorted(violated)


@settings(max_examples=12, deadline=None)
@given(st.lists(corner, min_size=2, max_size=2), corner, corner, st.integers(0, 999))
def test_fence_teammate_obstacle_and_keep_out_at_once_are_all_kept(
    starts: list[tuple[float, float]], tree: tuple[float, float], evader: tuple[float, float], seed: int
) -> None:
    scene = Corner(starts, tree, evader, seed)
    if scene.is_clear():
        assert scene.fly([_supervisor("p1"), _supervisor("p2")], 6, seed) == []


def test_its_twin_without_spatial_guards_violates_all_four() -> None:
    violated: set[str] = set()
    for seed in range(6):
        unguarded = [
            Supervisor(stops=(), limits=(SpeedGuard(),), spatial=(), rates=(AccelerationGuard(PARAMETERS),), finals=())
            for _ in range(2)
        ]
        scene = Corner([(50.0, 16.0), (58.0, 26.0)], (60.0, 22.0), (60.0, 27.0), seed)
        violated |= set(scene.fly(unguarded, 8, seed))
    assert violated == {"fence", "keep-out", "obstacle", "separation"}


@pytest.mark.parametrize("seed", range(3))
def test_pressed_into_a_corner_by_everything_the_setpoint_comes_to_rest(seed: int) -> None:
    """Fence on two sides, a tree, a standing teammate and the evader behind them: no limit cycle in what is sent."""
    supervisor, body = _supervisor(), Body("p1", (60.0, 24.0))
    trees, mate = discs_at((63.0, 23.0, 0.7)), Body("p2", (61.5, 28.0))
    random, sent = np.random.default_rng(seed), []
    for step in range(round(16 / PERIOD_S)):
        t_s = step * PERIOD_S
        context = context_of(body, t_s, team=(member_of(mate, 0.02),), target=target_at((64.0, 27.0, -5.0)), discs=trees)
        wish = np.array([4.0, 4.0, 0.0])
        sent.append(supervisor.check(Setpoint(wish, 0.0), noisy(context, random, 0.02)).setpoint.velocity_ned_m_s)
        body.fly(Setpoint(sent[-1], 0.0))
    settled = np.array(sent)[-100:, :2]
    assert np.hypot(*settled.T).mean() < 0.4
    assert FENCE.contains(Point(body.position[:2]))
    reversals = np.count_nonzero(np.diff(np.sign(np.where(np.abs(settled) > 0.5, settled, 0.0)), axis=0))
    assert reversals <= 4
