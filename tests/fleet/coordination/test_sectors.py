"""The division of the circle around the evader: fair, soonest, aware of what stands in the way, and calm."""

from __future__ import annotations

import itertools
import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.bearing import wrapped_rad
from flightapp.core.types import Array
from flightapp.fleet.coordination.arrival import arrival_times_s, detours_m
from flightapp.fleet.coordination.core import Coordinator, Voice
from flightapp.fleet.coordination.scene import Pursuer, Scene
from flightapp.fleet.coordination.sector_plan import SectorPlan
from flightapp.fleet.coordination.sectors import divide

RING_M = 2.2
OPEN = np.zeros((0, 3))
places = st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0))


def scene(
    *pursuers: tuple[float, float], velocity: tuple[float, float] = (0.0, 0.0), discs: Array = OPEN, speed_m_s: float = 5.0
) -> Scene:
    """The evader stands at the origin."""
    flown = tuple(Pursuer(f"p{k + 1}", north, east, speed_m_s) for k, (north, east) in enumerate(pursuers))
    return Scene(0.0, 0.0, *velocity, flown, discs)


@given(st.lists(places, min_size=1, max_size=6), st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_sectors_are_equal_and_each_has_one_pursuer(starts: list[tuple[float, float]], v_north: float, v_east: float) -> None:
    division = divide(scene(*starts, velocity=(v_north, v_east)), RING_M)
    bearings = np.sort(division.bearings_rad)
    gaps = np.diff(np.append(bearings, bearings[0] + 2.0 * math.pi))
    assert gaps == pytest.approx(np.full(len(starts), 2.0 * math.pi / len(starts)), abs=1e-6)
    assert np.isfinite(division.arrivals_s).all()


@given(st.lists(places, min_size=2, max_size=4, unique=True))
def test_no_exchange_of_seats_brings_the_last_one_there_much_sooner(starts: list[tuple[float, float]]) -> None:
    division = divide(scene(*starts), RING_M)
    ends = RING_M * np.stack((np.cos(division.bearings_rad), np.sin(division.bearings_rad)), axis=-1)
    times = arrival_times_s(np.array(starts), np.full(len(starts), 5.0), ends, np.zeros(2))
    rows = np.arange(len(starts))
    best = min(float(times[rows, list(order)].max()) for order in itertools.permutations(rows))
    assert float(division.arrivals_s.max()) <= best + 2.0 * RING_M / 5.0


@given(places, st.floats(0.5, 8.0), st.floats(0.0, 6.3), st.floats(0.0, 4.0))
def test_who_flies_the_told_time_straight_ahead_is_there(
    start: tuple[float, float], speed_m_s: float, heading_rad: float, evader_m_s: float
) -> None:
    velocity = evader_m_s * np.array((math.cos(heading_rad), math.sin(heading_rad)))
    time_s = float(arrival_times_s(np.array([start]), np.array([speed_m_s]), np.zeros((1, 2)), velocity)[0, 0])
    if speed_m_s > evader_m_s + 0.1:
        assert math.dist(velocity * time_s, start) == pytest.approx(speed_m_s * time_s, abs=1e-6)
    assert math.isfinite(time_s)
    assert time_s >= 0.0


def test_a_wall_across_one_way_is_in_the_arrival_time_and_beside_the_way_it_is_not() -> None:
    start, end = np.array((-30.0, 0.0)), np.array((-2.0, 0.0))
    wall = np.array([(-15.0, 0.0, 4.0)])
    longer = float(detours_m(start, end, wall, 0.9))
    assert longer == pytest.approx(2.0 * math.hypot(4.9, 14.0) - 28.0, rel=0.1)
    assert float(detours_m(start, end, wall + np.array((0.0, 6.0, 0.0)), 0.9)) == 0.0


def test_seats_do_not_swap_back_and_forth_where_two_divisions_are_as_good() -> None:
    """Two pursuers, one behind the other as seen from the evader, told with noise: who goes left is a coin's toss."""
    generator = random.Random(5)

    def orders(coordinator: Coordinator | None) -> int:
        """How often the pair has changed sides in 20 s; with a new coordinator at each plan nothing is kept."""
        sides, changes = None, 0
        for tick in range(100):
            east = [generator.gauss(0.0, 0.3) for _ in range(2)]
            seen = scene((-20.0, east[0]), (-22.0, east[1]))
            core = coordinator or Coordinator(SectorPlan(RING_M))
            (plan,) = core.step(0.2 * tick, Voice("p1", 1, is_own=True), seen, ())
            now = wrapped_rad(plan.seats[0].bearing_rad) > 0.0
            changes += sides is not None and now != sides
            sides = now
        return changes

    assert orders(None) > 10, "without a memory the noise exchanges them"
    assert orders(Coordinator(SectorPlan(RING_M))) == 0


def test_seats_are_exchanged_where_it_gains_seconds() -> None:
    core, voice = Coordinator(SectorPlan(RING_M)), Voice("p1", 1, is_own=True)
    (before,) = core.step(0.0, voice, scene((0.0, 10.0), (0.0, -10.0)), ())
    (after,) = core.step(0.2, voice, scene((0.0, -10.0), (0.0, 10.0)), ())
    assert abs(wrapped_rad(before.seats[0].bearing_rad - after.seats[0].bearing_rad)) == pytest.approx(math.pi, abs=0.1)
