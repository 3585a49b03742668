"""Depth cameras in the fast simulation: rendered frames, real perception, the same bits for a seed."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import ObstacleSet, TargetTrack, TeamMember
from flightapp.sim.batch import fly
from flightapp.sim.batch.depth_sensing import DepthSensing
from flightapp.sim.batch.families.layout import Start, disc
from flightapp.sim.batch.scenario import Scenario
from flightapp.sim.batch.world import World
from tests.sim.batch.stubs import command, scenario, set_moving, world

FAR_AWAY = Start(90.0, 90.0, 0.0)
SMALL = {"sensing__camera__width_px": 424, "sensing__camera__height_px": 240, "sensing__camera__focal_length_px": 210.8}


def depth(**overrides: object) -> Scenario:
    return scenario("a2-dense-depth", **{**SMALL, "pursuers__count": 1, **overrides})


def seen_by(of: Scenario, flown: World, ticks: int = 0, north_m_s: float = 0.0, yaw_rad: float = 0.0) -> ObstacleSet:
    """What the only pursuer perceives after some control periods of one command."""
    cameras = DepthSensing(of, flown, 5)
    for tick in range(ticks):
        cameras.obstacles(tick, [()], None)
        flown.advance(tick, [command(north_m_s, 0.0, yaw_rad), command(0.0, 0.0, 0.0)])
    return cameras.obstacles(ticks, [()], None)[0]


def surface_error_m(row: list[float], truth: list[float]) -> float:
    return abs(math.hypot(row[0], row[1]) - row[2] - (math.hypot(truth[0], truth[1]) - truth[2]))


def test_an_episode_is_the_same_bit_for_bit_and_the_seed_counts() -> None:
    short = depth(pursuers__count=2, time_limit_s=1.2)
    first, again, other = (fly(short, "ac2f", seed) for seed in (3, 3, 4))
    for field in dataclasses.fields(first):
        if field.name not in ("decision_ns", "sim_wall_ns"):
            assert getattr(first, field.name) == getattr(again, field.name), field.name
    assert first.path_length_m != other.path_length_m


@pytest.mark.parametrize("yaw_rad", [0.0, 2.0])
def test_discs_lie_where_the_obstacles_are_and_the_rest_is_unseen(yaw_rad: float) -> None:
    ahead = [disc(5.0 * math.cos(yaw_rad + a), 5.0 * math.sin(yaw_rad + a), 0.5) for a in (-0.4, 0.4)]
    behind = [disc(-5.0 * math.cos(yaw_rad), -5.0 * math.sin(yaw_rad), 0.5)]
    seen = seen_by(of := depth(), world(of, [Start(0.0, 0.0, yaw_rad)], FAR_AWAY, ahead + behind), ticks=5, yaw_rad=yaw_rad)
    for truth in ahead:
        near = [row for row in seen.discs.tolist() if math.dist(row[:2], truth[:2]) < 0.7]
        assert near
        assert min(surface_error_m(row, truth) for row in near) < 0.3
    assert all(min(math.dist(row[:2], truth[:2]) for truth in ahead) < 1.0 for row in seen.discs.tolist())
    backwards = (yaw_rad + math.pi) % math.tau
    assert any((backwards - low) % math.tau < (high - low) % math.tau for low, high in seen.unseen.tolist())


def test_what_is_seen_is_as_old_as_told_and_stays_in_place_while_flying_towards_it() -> None:
    of = depth(sensing__latency_s=0.06)
    flown = world(of, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [disc(8.0, 0.0, 0.5)])
    set_moving(flown, 0, 4.0, 0.0)
    seen = seen_by(of, flown, ticks=7, north_m_s=4.0)
    assert 0.7 - 0.06 - 1.0 / 30.0 - 0.02 <= seen.t_s <= 0.7 - 0.06 + 1e-9
    assert min(math.dist(row[:2], (8.0, 0.0)) for row in seen.discs.tolist()) < 0.35


def test_vehicles_that_are_known_of_are_not_obstacles() -> None:
    of = depth(pursuers__count=2)
    rows: dict[bool, int] = {}
    for known in (True, False):
        flown = world(of, [Start(0.0, 0.0, 0.0), Start(4.0, 1.0, 0.0)], Start(4.0, -1.0, 0.0), [])
        states = flown.states(0.0)
        team = [(TeamMember("p2", states[1], "coarse", None, 0.0),) if known else (), ()]
        target = TargetTrack(0.0, states[2].position_ned_m, states[2].velocity_ned_m_s, np.eye(6), 0.0) if known else None
        cameras = DepthSensing(of, flown, 5)
        for tick in range(6):
            seen = cameras.obstacles(tick, team, target)
            flown.advance(tick, [command(0.0, 0.0, 0.0)] * 3)
        rows[known] = len(seen[0].discs)
    assert rows == {True: 0, False: 2}


def test_moving_obstacles_are_seen_where_they_are() -> None:
    of = depth()
    flown = world(of, [Start(0.0, 0.0, 0.0)], FAR_AWAY, [disc(5.0, -1.0, 0.4, 0.0, 1.0)])
    seen = seen_by(of, flown, ticks=15)
    truth = (5.0, -1.0 + seen.t_s)
    assert min(math.dist(row[:2], truth) for row in seen.discs.tolist()) < 0.5


@pytest.mark.parametrize(
    ("name", "overrides", "sentence"),
    [
        ("a2-dense-depth", {"sensing__range_m": 5.0}, "sensing.range_m = 5.0: kind = 'depth' sees what sensing.camera shows"),
        ("a2-dense-depth", {"sensing__camera__rate_hz": 90.0}, "sensing.camera.rate_hz = 90.0: at most 50, one frame each"),
        ("a2-dense-depth", {"sensing__camera__range_max_m": 0.2}, "range_max_m = 0.2: must be greater than range_min_m = 0.3"),
        ("a2-dense", {"sensing__camera__rate_hz": 15.0}, "sensing.camera: kind = 'ideal' has no camera; set kind = 'depth'"),
        ("a2-dense", {"sensing__kind": "lidar"}, "sensing.kind = 'lidar': must be 'ideal' or 'depth'"),
        ("a2-dense-depth", {"sensing__perception__band_m": 0.0}, "sensing.perception.band_m"),
    ],
)
def test_what_is_wrong_is_one_sentence(name: str, overrides: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError) as refusal:
        scenario(name, **overrides)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)
