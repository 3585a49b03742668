"""Walls: contact in continuous time, against samples; who flies into one; what strategies see that know only discs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Boundary
from flightapp.sim.batch.families.layout import Layout, Start, disc_rows
from flightapp.sim.batch.walls import cover_discs, first_at_wall, wall_distance_m, way_wall_distance_m
from flightapp.sim.batch.world import World
from tests.sim.batch.stubs import AREA, FAR, command, scenario

BLOCK = np.array([[10.0, -5.0], [11.0, -5.0], [11.0, 5.0], [10.0, 5.0]])
MICROMETRES = st.integers(-3_000_000, 3_000_000).map(lambda count: count * 1e-6)
"""Places differ by what a place can differ by: with 1e-251 m between them products of lengths vanish."""
PLACE = st.tuples(MICROMETRES, MICROMETRES)


def world(pursuers: list[Start], evader: Start, sees_walls: bool = True, solid: bool = False) -> World:
    of = scenario("forest", pursuers__count=len(pursuers), evader__solid=solid)
    layout = Layout(disc_rows([]), Boundary(FAR.vertices_m, False), tuple(pursuers), evader, AREA, polygons=(BLOCK,))
    return World(of, layout, 1, 2, sees_walls)


@settings(max_examples=30, deadline=None)
@given(PLACE, PLACE, PLACE, PLACE, st.floats(0.05, 1.0))
def test_contact_is_where_samples_find_it(
    a: tuple[float, float], b: tuple[float, float], p: tuple[float, float], q: tuple[float, float], reach_m: float
) -> None:
    if math.dist(p, q) < 1e-3:
        return
    shares = np.linspace(0.0, 1.0, 301)
    way = np.array([wall_distance_m(a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), *p, *q) for s in shares])
    step_m = math.dist(a, b) / 300.0
    assert way.min() - step_m - 1e-9 <= way_wall_distance_m(*a, *b, *p, *q) <= way.min() + 1e-9
    first = first_at_wall(*a, *b, *p, *q, reach_m)
    touching = np.flatnonzero(way <= reach_m)
    if len(touching):
        assert first == pytest.approx(shares[touching[0]], abs=3.5e-3)
    elif way.min() > reach_m + step_m:
        assert first > 1.0


def test_a_pursuer_that_flies_into_a_wall_collides_at_its_surface() -> None:
    alone = world([Start(9.5, 0.0, 0.0)], Start(50.0, 0.0, 0.0))
    for tick in range(10):
        if alone.advance(tick, [command(1.0, 0.0), command(0.0, 0.0)]):
            break
    assert alone.collided_with == "obstacle"
    assert alone.vehicles[0]["n"] == pytest.approx(10.0 - 0.15, abs=1e-9)
    assert alone.record["clearance"][0] == pytest.approx(0.0, abs=1e-9)


def test_a_solid_evader_slides_along_a_wall_and_another_passes() -> None:
    for solid, north in ((True, 10.0 - 0.15), (False, 10.4)):
        alone = world([Start(0.0, 0.0, 0.0)], Start(9.6, 0.0, 0.0), solid=solid)
        for tick in range(10):
            alone.advance(tick, [command(0.0, 0.0), command(0.8, 0.3)])
        assert alone.vehicles[1]["n"] == pytest.approx(north, abs=1e-6)
        assert alone.vehicles[1]["e"] == pytest.approx(0.3, abs=1e-6)


def test_discs_along_a_wall_are_seen_only_by_pursuers_that_do_not_know_it() -> None:
    for sees_walls in (True, False):
        seen = world([Start(5.0, 0.0, 0.0)], Start(6.0, 0.0, 0.0), sees_walls).obstacles(0)
        assert (len(seen[0].discs) > 0) == sees_walls
        assert len(seen[1].discs) == 0


def test_the_discs_leave_no_part_of_a_wall_out_and_hardly_stand_out_of_it() -> None:
    discs = cover_discs([BLOCK])
    assert (discs[:, 0] - discs[:, 2] >= 10.0 - 0.11).all()
    assert (discs[:, 0] + discs[:, 2] <= 11.0 + 0.11).all()
    for north, east in [*((10.0, e) for e in np.linspace(-5.0, 5.0, 201)), *((n, 5.0) for n in np.linspace(10.0, 11.0, 21))]:
        assert (np.hypot(discs[:, 0] - north, discs[:, 1] - east) - discs[:, 2]).min() < 1e-9
