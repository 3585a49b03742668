from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.geofence import GeofenceGuard
from flightapp.safety.outline import Outline
from tests.safety.closed_loop import LIMITS, PARAMETERS, Body, context_of, fly, random_wishes, setpoint_of, supervisor_of

SQUARE = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
NOTCHED = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (2.0, 10.0), (2.0, 0.0), (-2.0, 0.0), (-2.0, 10.0), (-10.0, 10.0))
FENCES = {"square": SQUARE, "clockwise square": tuple(reversed(SQUARE)), "notched": NOTCHED}

place = st.floats(-14, 14)
speed = st.floats(-8, 8)


def _start(polygon: Polygon, seed: int) -> list[float]:
    rng = np.random.default_rng(seed)
    while True:
        where = rng.uniform(-9.4, 9.4, 2)
        if polygon.contains(Point(where)) and polygon.exterior.distance(Point(where)) > 0.5:
            return where.tolist()


@pytest.mark.parametrize("vertices", FENCES.values(), ids=FENCES.keys())
def test_nobody_leaves_the_fence_and_without_the_guard_everybody_does(vertices: tuple[tuple[float, float], ...]) -> None:
    polygon = Polygon(vertices)
    unsafe = 0
    for seed in range(8):
        heading = 0.8 * seed
        outward = np.array([8 * math.cos(heading), 8 * math.sin(heading), 0.0])
        for wish in (random_wishes(seed), lambda t, body, v=outward: v):
            start = _start(polygon, seed)
            path, _ = fly(
                Body("p1", start), wish, supervisor_of(GeofenceGuard(vertices, PARAMETERS)), 6, lambda t, b: context_of(b, t)
            )
            assert all(polygon.contains(Point(p[:2])) for p in path[::4])
            twin, _ = fly(Body("p1", start), wish, None, 6, lambda t, b: context_of(b, t))
            unsafe += not all(polygon.contains(Point(p[:2])) for p in twin[::4])
    assert unsafe >= 12


def test_outside_the_vehicle_is_pushed_back_and_faster_motion_inwards_is_left() -> None:
    guard = GeofenceGuard(SQUARE, PARAMETERS)
    body = Body("p1", (12.0, 0.0))
    out = guard.check(setpoint_of(3.0, 1.0), context_of(body))
    assert out.setpoint.velocity_ned_m_s.tolist() == pytest.approx([-PARAMETERS.push_back_m_s, 1.0, 0.0])
    assert out.reason == "outside the fence, 2.0 m: going back at 1.0 m/s"
    back = guard.check(setpoint_of(-3.0, 1.0), context_of(body))
    assert back.setpoint.velocity_ned_m_s.tolist() == [-3.0, 1.0, 0.0]
    assert back.reason == ""


@pytest.mark.parametrize("where", [(10.0, 0.0), (10.0, 10.0), (2.0, 5.0), (0.0, 0.0)])
def test_exactly_on_the_line_nothing_leads_outwards(where: tuple[float, float]) -> None:
    polygon = Polygon(NOTCHED)
    guard = GeofenceGuard(NOTCHED, PARAMETERS)
    for degrees in range(0, 360, 15):
        wish = setpoint_of(4 * math.cos(math.radians(degrees)), 4 * math.sin(math.radians(degrees)))
        velocity = guard.check(wish, context_of(Body("p1", where))).setpoint.velocity_ned_m_s
        ahead = Point(np.array(where) + 1e-3 * velocity[:2])
        assert polygon.distance(ahead) < 1e-5


@settings(max_examples=150, deadline=None)
@given(place, place, speed, speed, speed, speed)
def test_never_faster_than_wish_or_push_and_never_more_outward(
    n: float, e: float, vn: float, ve: float, wn: float, we: float
) -> None:
    guard = GeofenceGuard(NOTCHED, PARAMETERS)
    context = context_of(Body("p1", (n, e), (vn, ve, 0.0)))
    wish = setpoint_of(wn, we, 0.3, 1.0)
    verdict = guard.check(wish, context)
    out = verdict.setpoint.velocity_ned_m_s
    assert out[2] == 0.3
    assert verdict.setpoint.yaw_rad == 1.0
    bounds = guard.bounds((wn, we), 100.0, context)
    pushed = max((-bound.bound_m_s for bound in bounds), default=0.0)
    if pushed <= 0.0:
        assert math.hypot(out[0], out[1]) <= math.hypot(wn, we) + 1e-6
    assert pushed <= PARAMETERS.push_back_m_s
    for bound in bounds:
        assert bound.excess_m_s((out[0], out[1])) <= max(0.0, -bound.bound_m_s) + 1e-6
        if bound.distance_m > 0.5 * PARAMETERS.fence_margin_m and Polygon(NOTCHED).contains(Point(n, e)):
            assert bound.bound_m_s >= 0.0
    if verdict.reason == "":
        assert verdict.setpoint is wish


def test_the_command_settles_at_the_border() -> None:
    supervisor = supervisor_of(GeofenceGuard(SQUARE, PARAMETERS))
    _, sent = fly(Body("p1", (0.0, 0.0)), lambda t, b: np.array([5.0, 0.5, 0.0]), supervisor, 16, lambda t, b: context_of(b, t))
    assert np.abs(np.diff(sent[:, 0])).sum() < 2 * 5.0 + 0.5
    assert np.abs(sent[-25:, 0]).max() < 0.02


@settings(max_examples=200, deadline=None)
@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-6, 6))
def test_the_bound_never_grows_towards_the_line_and_beyond_it(one: float, other: float, closing: float) -> None:
    braking = horizontal_braking(LIMITS, PARAMETERS)
    nearer, farther = (braking.kept_m_s(inside, closing, 0.5, 1.0, 0.1) for inside in sorted((one, other)))
    assert nearer <= farther


def test_a_fence_of_many_corners_is_the_polygon_that_it_is() -> None:
    """Inside or not and how far, against shapely, for a star whose corners point inwards and outwards in turn."""
    star = [
        (r * math.cos(a), r * math.sin(a)) for a, r in zip(np.linspace(0, 2 * math.pi, 25)[:-1], [9.0, 4.0] * 12, strict=True)
    ]
    polygon, outline = Polygon(star), Outline(star)
    for north, east in np.random.default_rng(0).uniform(-10, 10, (300, 2)):
        look = outline.seen_from(north, east, 2.0)
        distance = polygon.exterior.distance(Point(north, east))
        assert look.inside_m == pytest.approx(distance if polygon.contains(Point(north, east)) else -distance)
        assert all(edge.distance_m < 2.0 for edge in look.near)
        assert bool(look.near) == (distance < 2.0)
