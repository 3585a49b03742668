"""Planned ways of one vehicle: inside the fence, clear of what is known and seen, and an answer whatever happens."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from shapely.geometry import LineString, Polygon

from flightapp.config.known_obstacles import KnownBox
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.types import Array, ObstacleSet
from flightapp.runtime.composition import limits_of
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.way_planner import PlannedWay, WayPlanner
from tests.sim.virtual.test_way_home import MISSION, SIM

CORNERED = ((-25.0, -25.0), (25.0, -25.0), (25.0, 25.0), (5.0, 25.0), (5.0, -5.0), (-5.0, -5.0), (-5.0, 25.0), (-25.0, 25.0))
"""Two arms, side by side and open to each other in the west only."""
NOTHING = ObstacleSet(0.0, np.zeros((0, 7)), np.zeros((0, 2)))
ONE_ARM, OTHER_ARM = np.array((-15.0, 15.0, -4.0)), np.array((15.0, 15.0, -4.0))


def planner(**changes: Any) -> WayPlanner:
    mission, profile = load_mission(MISSION), load_profile(SIM)
    volume = mission.flight_volume.model_copy(update={"vertices_m": CORNERED})
    mission = mission.model_copy(update={"flight_volume": volume, "known_obstacles": (), **changes})
    vehicle = mission.vehicles[0]
    clock = SimpleNamespace(now_s=lambda: 0.0)
    rooms = SimpleNamespace(clock=clock, mission=mission, profile=profile, vehicle=vehicle, limits=limits_of(vehicle, profile))
    return WayPlanner(cast(Rooms, rooms))


def places(way: PlannedWay) -> Array:
    assert way.trajectory is not None, way.text
    return np.array([way.trajectory.at(float(t)).position_ned_m for t in np.arange(0.0, way.trajectory.duration_s, 0.05)])


def disc(north_m: float, top_m: float, speed_m_s: float = 0.0) -> ObstacleSet:
    """A hedge of discs across the western part."""
    rows = [(north_m, east, 1.0, speed_m_s, 0.0, -top_m, 0.0) for east in np.arange(-25.0, 26.0, 1.5)]
    return replace(NOTHING, discs=np.array(rows))


def test_a_way_stays_inside_the_fence() -> None:
    flown = places(planner().plan("way", ONE_ARM, OTHER_ARM, NOTHING))
    assert Polygon(CORNERED).buffer(-0.8).contains(LineString(flown[:, :2]))


def test_what_stands_is_flown_over_and_what_moves_is_not() -> None:
    ways = planner()
    start, goal = np.array((-15.0, -15.0, -4.0)), np.array((15.0, -15.0, -4.0))
    over = places(ways.plan("way", start, goal, disc(0.0, 5.0)))
    assert -over[:, 2].min() > 5.8
    blocked = ways.plan("way", start, goal, disc(0.0, 5.0, speed_m_s=1.0))
    assert blocked.trajectory is None
    assert blocked.text.startswith("no way around what is known: ")


@pytest.mark.parametrize("height_m", [2.0, 5.5, 6.2])
def test_straight_ways_are_clear_where_body_and_margin_fit(height_m: float) -> None:
    low = KnownBox(shape="box", north_m=-15.0, east_m=0.0, length_m=2.0, width_m=60.0, top_m=5.0)
    ways = planner(known_obstacles=(low,))
    here, there = np.array((-20.0, 0.0, -height_m)), np.array((-10.0, 0.0, -height_m))
    assert ways.is_clear(NOTHING, here, there) is (height_m > 5.8)
    assert ways.is_clear(NOTHING, here, here)
    assert not ways.is_clear(disc(-12.0, math.inf), here, there)


def test_a_planner_that_breaks_is_no_way(monkeypatch: pytest.MonkeyPatch) -> None:
    ways = planner()
    way = ways.plan("way", np.array((math.nan, 0.0, 0.0)), OTHER_ARM, NOTHING)
    assert way.trajectory is None
    assert "the planner failed, ValueError: " in way.text
