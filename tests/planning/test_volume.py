"""AC2F with height: meeting times, what is in the way at a height, and decisions in space."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array, Boundary, Decision, Observation, ObstacleSet, TargetTrack, VehicleState
from flightapp.planning.ac2f.arrival import intercept_time_s
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.planning.ac2f.volume.clearance import PASSED_SHARE, HeightMemory, vertical_room
from flightapp.planning.ac2f.volume.intercept import meeting_time_s
from flightapp.planning.ac2f.volume.parameters import VolumeParameters
from flightapp.planning.ac2f.volume.planner import VolumePlanner
from flightapp.planning.api import Planner
from flightapp.planning.registry import make_planner
from flightapp.runtime.hover import Hover, wish_of
from tests.planning.closed_loop import limits

LINE = Boundary(np.array([[-60.0, -30.0], [-60.0, 30.0]]), False)
UNKNOWN = (-math.inf, math.inf)
PERIOD_S = 0.1
metres, speeds = st.floats(-40.0, 40.0), st.floats(-3.0, 3.0)


def disc(north: float, east: float, radius: float, top_m: float | None = None) -> list[float]:
    """One that stands on the ground; of unknown height without `top_m`."""
    return [north, east, radius, 0.0, 0.0, *(UNKNOWN if top_m is None else (-top_m, 0.0))]


def discs_of(*rows: list[float]) -> Array:
    return np.array(rows, dtype=np.float64).reshape(-1, 7)


def seen(
    t_s: float, own: tuple[float, ...], evader: tuple[float, ...], discs: Array, velocity: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> Observation:
    """Own and evader as (north, east, height)."""
    place = np.array((own[0], own[1], -own[2]))
    track = TargetTrack(t_s, np.array((evader[0], evader[1], -evader[2])), np.array(evader[3:] or (0.0,) * 3), np.eye(6), 0.0)
    state = VehicleState(t_s, place, np.array(velocity), 0.0)
    return Observation(t_s, PERIOD_S, state, (), track, ObstacleSet(t_s, discs, np.zeros((0, 2))), LINE)


def planner(space: str = "volume", **volume: object) -> Planner:
    capture = {"mode": "first", "radius_m": 0.5, "dwell_s": 0.0}
    return make_planner("ac2f", limits=limits(), parameters={"capture": capture, "volume": {"space": space, **volume}})


@given(metres, metres, speeds, speeds, st.floats(0.5, 4.0))
@settings(max_examples=60, deadline=None)
def test_at_equal_heights_the_meeting_is_the_planar_one(n: float, e: float, vn: float, ve: float, speed: float) -> None:
    planar = intercept_time_s(n, e, vn, ve, speed)
    assert meeting_time_s((n, e, 0.0), (vn, ve, 0.0), speed, 2.0, 1.0) == planar or math.isnan(planar)


@given(metres, metres, st.floats(-12.0, 12.0), speeds, speeds, st.floats(-2.5, 2.5), st.floats(1.0, 5.0), st.floats(0.5, 2.0))
@settings(max_examples=60, deadline=None)
def test_the_meeting_is_the_first_time_at_which_the_place_is_within_reach(
    n: float, e: float, d: float, vn: float, ve: float, vd: float, speed: float, climb: float
) -> None:
    sink = 0.7 * climb
    met = meeting_time_s((n, e, d), (vn, ve, vd), speed, climb, sink)
    times = np.linspace(0.0, 60.0, 6001)
    gap = np.maximum(
        np.hypot(n + vn * times, e + ve * times) - speed * times,
        np.maximum(d + vd * times - sink * times, -d - vd * times - climb * times),
    )
    reached = times[gap <= -1e-6]
    if len(reached):
        assert met <= reached[0] + 1e-6
    assert math.isnan(met) or not (gap[times < met - 1e-6] < -1e-6).any()
    if not math.isnan(met):
        assert math.hypot(n + vn * met, e + ve * met) <= speed * met + 1e-5 * (1.0 + met)
        assert -climb * met - 1e-5 * (1.0 + met) <= d + vd * met <= sink * met + 1e-5 * (1.0 + met)


@given(st.floats(3.0, 14.0), st.floats(-2.0, 2.0), st.floats(3.0, 10.0))
@settings(max_examples=40, deadline=None)
def test_a_vehicle_that_may_sink_no_faster_is_never_below_the_top_of_what_it_passes(
    height: float, rate: float, top: float
) -> None:
    """Against a vehicle that answers a period late and changes its vertical velocity no faster than it may."""
    p = VolumeParameters(height_min_m=1.0)
    rows, offsets = discs_of(disc(0.0, 0.0, 1.0, top)), np.array([-1.0])
    down, down_m_s, late = -height, rate, rate
    passes = not vertical_room(rows, offsets, down, down_m_s, 5.0, p).blocking[0]
    for _ in range(80):
        room = vertical_room(rows, offsets, down, down_m_s, 5.0, p)
        if passes:
            assert -down - top >= (PASSED_SHARE - 0.05) * p.obstacle_margin_m
        wanted, late = late, min(2.0, room.sink_max_m_s)
        change = p.acceleration_max_m_s2 * PERIOD_S
        before, down_m_s = down_m_s, min(down_m_s + change, max(down_m_s - change, wanted))
        down += 0.5 * PERIOD_S * (before + down_m_s)
    assert not passes or not room.blocking[0]
    assert -down >= p.height_min_m - 0.3 or height < p.height_min_m


def test_only_what_is_known_to_end_below_or_above_is_passed() -> None:
    rows = discs_of(disc(5.0, 0.0, 1.0, 4.0), disc(5.0, 0.0, 1.0, 9.0), disc(5.0, 0.0, 1.0))
    rows = np.concatenate((rows, [[5.0, 0.0, 1.0, 0.0, 0.0, -20.0, -12.0]]))
    room = vertical_room(rows, np.full(4, 4.0), -8.0, 0.0, 1.0, VolumeParameters())
    assert room.blocking.tolist() == [False, True, True, False]
    sinking = vertical_room(rows, np.full(4, 4.0), -8.0, 4.0, 1.0, VolumeParameters())
    assert sinking.blocking.tolist()[0], "what it sweeps until it could have stopped sinking is not clear of the top"


def test_what_was_flown_over_is_kept_away_from_out_of_view_and_forgotten_in_the_end() -> None:
    memory = HeightMemory(10.0)
    pole, other = discs_of(disc(5.0, 0.0, 0.3, 4.0)), discs_of(disc(9.0, 9.0, 0.3))
    assert len(memory.with_remembered(ObstacleSet(0.0, pole, np.zeros((0, 2))))) == 1
    assert memory.with_remembered(ObstacleSet(5.0, other, np.zeros((0, 2)))).tolist() == [*other.tolist(), *pole.tolist()]
    assert memory.with_remembered(ObstacleSet(11.0, other, np.zeros((0, 2)))).tolist() == other.tolist()


def flown(by: Planner, own: tuple[float, float, float], evader: tuple[float, ...], discs: Array, steps: int) -> list[Decision]:
    """A vehicle that flies what is decided at once, and an evader that moves steadily: north, east, height, velocity NED."""
    place, velocity, told = np.array((own[0], own[1], -own[2])), np.zeros(3), []
    for step in range(steps):
        t_s = PERIOD_S * step
        target = np.array((evader[0], evader[1], -evader[2])) + t_s * np.array(evader[3:])
        at = (float(target[0]), float(target[1]), -float(target[2]), *evader[3:])
        decision = by.step(seen(t_s, (place[0], place[1], -place[2]), at, discs, tuple(velocity)))
        told.append(decision)
        if decision.diagnostics["captured"]:
            break
        velocity = decision.velocity_ned_m_s
        place = place + PERIOD_S * velocity
    return told


def test_without_height_the_planner_is_the_planar_one() -> None:
    assert type(planner("plane")) is Ac2fPlanner
    assert type(make_planner("ac2f", limits=limits())) is Ac2fPlanner


def test_at_one_height_among_obstacles_of_unknown_height_it_decides_as_in_the_plane() -> None:
    discs = discs_of(disc(8.0, 0.5, 0.6), disc(14.0, -1.0, 0.8))
    chase = ((0.0, 0.0, 5.0), (25.0, 0.0, 5.0, -1.0, 0.5, 0.0), discs, 80)
    in_space, in_plane = flown(planner(), *chase), flown(planner("plane"), *chase)
    assert [one.velocity_ned_m_s.tolist() for one in in_space] == [one.velocity_ned_m_s.tolist() for one in in_plane]
    assert in_space[-1].diagnostics["captured"]
    assert in_plane[-1].diagnostics["captured"]


def test_it_climbs_to_the_evader_over_what_it_can_pass_and_captures_it_in_space() -> None:
    wall = discs_of(*(disc(10.0, 0.8 * k, 0.5, 4.0) for k in range(-12, 13)))
    told = flown(planner(acceleration_max_m_s2=3.0), (0.0, 0.0, 5.0), (25.0, 0.0, 9.0, 0.0, 0.0, 0.0), wall, 150)
    assert told[-1].diagnostics["captured"]
    assert max(abs(float(one.velocity_ned_m_s[1])) for one in told) < 0.5, "straight over the wall"
    assert len(told) < 90


def test_what_its_search_weighed_is_told_as_in_the_plane() -> None:
    near = ((0.0, 0.0, 5.0), (3.0, 0.5, 5.0, 0.0, 0.0, 0.0), discs_of(), 3)
    in_space, in_plane = planner(), planner("plane")
    flown(in_space, *near)
    flown(in_plane, *near)
    assert isinstance(in_space, VolumePlanner)
    assert isinstance(in_plane, Ac2fPlanner)
    told, planar = in_space.candidates(), in_plane.candidates()
    assert told is not None
    assert planar is not None
    assert repr(told) == repr(planar)


def test_right_below_the_evader_it_is_not_captured() -> None:
    pursuer = planner()
    decision = pursuer.step(seen(0.0, (0.0, 0.0, 5.0), (0.1, 0.0, 9.0), discs_of()))
    assert not decision.diagnostics["captured"]
    assert decision.velocity_ned_m_s[2] < 0.0, "up"
    assert decision.diagnostics["meeting_s"] == pytest.approx(2.0)


def test_it_does_not_arrive_long_before_it_is_at_the_height() -> None:
    slow = planner().step(seen(0.0, (0.0, 0.0, 5.0), (4.0, 0.0, 15.0), discs_of(), (4.0, 0.0, 0.0)))
    fast = planner().step(seen(0.0, (0.0, 0.0, 5.0), (4.0, 0.0, 5.0), discs_of(), (4.0, 0.0, 0.0)))
    assert 0.0 < np.hypot(*slow.velocity_ned_m_s[:2]) < 1.0 < np.hypot(*fast.velocity_ned_m_s[:2])


def test_the_height_loop_does_not_pull_back_who_flies_the_height_itself() -> None:
    own = VehicleState(0.0, np.array((0.0, 0.0, -9.0)), np.zeros(3), 0.0)
    told = planner().step(seen(0.0, (0.0, 0.0, 9.0), (20.0, 0.0, 9.0), discs_of()))
    flat = planner("plane").step(seen(0.0, (0.0, 0.0, 9.0), (20.0, 0.0, 9.0), discs_of()))
    hover = Hover(5.0, 2.0, 1.0)
    assert wish_of(told, hover, own, feed_forward=False).velocity_ned_m_s[2] == pytest.approx(0.0)
    assert wish_of(flat, hover, own, feed_forward=False).velocity_ned_m_s[2] == pytest.approx(2.0), "down to the mission's height"


def test_it_climbs_and_sinks_within_the_limit_of_each() -> None:
    slow = replace(limits(), climb_rate_max_m_s=3.0, sink_rate_max_m_s=1.0)
    for height, fastest in ((14.0, -3.0), (4.0, 1.0)):
        by = make_planner("ac2f", limits=slow, parameters={"volume": {"space": "volume", "acceleration_max_m_s2": 5.0}})
        told = flown(by, (0.0, 0.0, 9.0), (30.0, 0.0, height, 0.0, 0.0, 0.0), discs_of(), 12)
        assert max((float(one.velocity_ned_m_s[2]) for one in told), key=abs) == pytest.approx(fastest)


def test_far_away_it_flies_to_the_height_of_the_game_point_and_near_to_the_evader_s() -> None:
    far = planner().step(seen(0.0, (0.0, 0.0, 4.0), (40.0, 0.0, 10.0), discs_of()))
    assert far.goal_ned_m is not None
    assert far.diagnostics["game_height_m"] == pytest.approx(-far.goal_ned_m[2])
    assert -far.goal_ned_m[2] > 10.5, "who is below leaves the evader more above"
    near = planner().step(seen(0.0, (0.0, 0.0, 4.0), (10.0, 0.0, 10.0), discs_of()))
    assert near.goal_ned_m is not None
    assert -near.goal_ned_m[2] == 10.0
    level = planner().step(seen(0.0, (0.0, 0.0, 10.0), (40.0, 0.0, 10.0), discs_of()))
    assert level.diagnostics["game_height_m"] == 10.0


def test_a_wall_that_only_the_planar_game_holds_is_not_told_as_contested() -> None:
    over_its_head = ((-56.0, 0.0, 3.0), (-48.0, 0.0, 25.0), discs_of())
    assert planner("plane").step(seen(0.0, *over_its_head)).diagnostics["contested"] is True
    assert planner().step(seen(0.0, *over_its_head)).diagnostics["contested"] is False
    assert planner().step(seen(0.0, (-56.0, 0.0, 25.0), (-48.0, 0.0, 25.0), discs_of())).diagnostics["contested"] is True
