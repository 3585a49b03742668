"""Two vehicles, and two parts of one vehicle, never judge the same gap differently."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flightapp.config.mission import Cylinder, Obstacles
from flightapp.core.clearance import clearance_m, closest_approach_m, way_gap_m
from flightapp.core.types import Array
from flightapp.planning.ac2f.scene import inflate, scene_clearance_m
from flightapp.planning.ac2f.sweep import roll_out, sweep
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.sim.batch.families.layout import Start, disc
from flightapp.sim.batch.records import FLYING
from flightapp.sim.world import World
from tests.safety.closed_loop import LIMITS, PARAMETERS, Body, context_of, discs_at
from tests.sim.batch.stubs import command, scenario, set_moving, world

BODY_M = LIMITS.body_radius_m
COARSE = scenario(pursuers__count=1, sub_step_s=0.1)
coordinate = st.floats(-6.0, 6.0)
cylinders = st.lists(st.tuples(coordinate, coordinate, st.floats(0.1, 1.5)), min_size=1, max_size=6)
moving = st.lists(
    st.tuples(coordinate, coordinate, st.floats(0.1, 1.0), st.just(0.0) | st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
    min_size=1,
    max_size=6,
)


def planned_m(place: tuple[float, float], discs: Array, margin_m: float) -> float:
    """What the planner makes of it, its margin taken back."""
    scene = np.zeros((len(discs), 6))
    count = inflate(discs, *place, 0.0, BODY_M + margin_m, 1e3, np.zeros((0, 2)), 0.0, 0.0, scene)
    return scene_clearance_m(scene[:count], *place, 1e3) + margin_m


@given(st.tuples(coordinate, coordinate), cylinders)
def test_planner_supervisor_and_metrics_agree_on_a_place(
    place: tuple[float, float], rows: list[tuple[float, float, float]]
) -> None:
    discs = discs_at(*rows)
    gap_m = clearance_m(np.array(place), discs, BODY_M)
    standing = [Cylinder(north_m=n, east_m=e, radius_m=r, height_m=9.0) for n, e, r in rows]
    truth = World(Obstacles(cylinders=tuple(standing)))
    assert truth.signed_distance_m(*place, -1.0) - BODY_M == pytest.approx(gap_m, abs=1e-9)
    assume(gap_m > 0.1)  # within its margin the planner shrinks a disc, so that the way out stays open
    assert planned_m(place, discs, 0.05) == pytest.approx(gap_m, abs=1e-9)
    bounds = ObstacleStopGuard(PARAMETERS).bounds((5.0, 0.0), 5.0, context_of(Body("p1", place), discs=discs))
    if gap_m < 1.0:
        assert min(bound.distance_m for bound in bounds) == pytest.approx(gap_m, abs=1e-9)


def swept_m(way: Array, rows: list[tuple[float, ...]], reach_m: float, period_s: float) -> float:
    """The clearance that the dynamic window gives to the straight `way` (2,) from the origin in one period."""
    scene = np.array([(n, e, r + reach_m, vn, ve, 0.0) for n, e, r, vn, ve in rows])
    speed, course = math.hypot(*way) / period_s, math.atan2(way[1], way[0])
    north, east, ends = np.zeros((2, 1)), np.zeros((2, 1)), np.zeros((2, 1))
    speeds, turns, clearances, verdicts = np.array([speed]), np.zeros(1), np.zeros(1), np.zeros(1, np.int64)
    roll_out(0.0, 0.0, course, speeds, turns, period_s, north, east, ends[0], ends[1])
    sweep(scene, speeds, turns, period_s, 1e3, 4.0, 0.3, 4, False, north, east, ends[0], ends[1], clearances, verdicts)
    return float(clearances[0])


@settings(deadline=None)
@given(st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)), moving)
def test_planner_simulator_and_metrics_agree_on_a_way_among_moving_obstacles(
    velocity: tuple[float, float], rows: list[tuple[float, float, float, float, float]]
) -> None:
    truth = world(COARSE, [Start(0.0, 0.0, 0.0)], Start(80.0, 80.0, 0.0), [disc(*row) for row in rows])
    set_moving(truth, 0, *velocity)
    outcome = truth.advance(0, [command(*velocity), command(0.0, 0.0, 0.0)])
    assume(outcome == FLYING)
    period_s, reach_m = COARSE.control_period_s, COARSE.pursuers.body_radius_m
    way = np.array((truth.vehicles[0]["n"], truth.vehicles[0]["e"]))
    gaps = []
    for n, e, radius, vn, ve in rows:
        start, along = np.array((-n, -e)), way - period_s * np.array((vn, ve))
        gaps.append(way_gap_m(*start, *along, radius + reach_m))
        assert closest_approach_m(start, start + along)[0] - radius - reach_m == pytest.approx(gaps[-1], abs=1e-9)
    assert float(truth.record["clearance"][0]) == pytest.approx(min(gaps), abs=1e-9)
    assert swept_m(way, rows, reach_m, period_s) == pytest.approx(min(gaps), abs=1e-9)
