from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from flightapp.safety.guards.geofence import GeofenceGuard
from tests.safety.closed_loop import PARAMETERS, Body, context_of, fly, random_wishes, setpoint_of, supervisor_of

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


def test_outside_only_motion_inwards_is_left() -> None:
    guard = GeofenceGuard(SQUARE, PARAMETERS)
    body = Body("p1", (12.0, 0.0))
    out = guard.check(setpoint_of(3.0, 1.0), context_of(body))
    assert out.setpoint.velocity_ned_m_s.tolist() == pytest.approx([0.0, 1.0, 0.0])
    assert "outside the fence" in out.reason
    assert "2.0 m" in out.reason
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
def test_never_faster_and_never_more_outward(n: float, e: float, vn: float, ve: float, wn: float, we: float) -> None:
    guard = GeofenceGuard(NOTCHED, PARAMETERS)
    context = context_of(Body("p1", (n, e), (vn, ve, 0.0)))
    wish = setpoint_of(wn, we, 0.3, 1.0)
    verdict = guard.check(wish, context)
    out = verdict.setpoint.velocity_ned_m_s
    assert math.hypot(out[0], out[1]) <= math.hypot(wn, we) + 1e-6
    assert out[2] == 0.3
    assert verdict.setpoint.yaw_rad == 1.0
    for bound in guard.bounds((wn, we), 100.0, context):
        assert bound.excess_m_s((out[0], out[1])) <= 1e-6
        assert bound.bound_m_s >= 0.0
    if verdict.reason == "":
        assert verdict.setpoint is wish


def test_the_command_settles_at_the_border() -> None:
    supervisor = supervisor_of(GeofenceGuard(SQUARE, PARAMETERS))
    _, sent = fly(Body("p1", (0.0, 0.0)), lambda t, b: np.array([5.0, 0.5, 0.0]), supervisor, 16, lambda t, b: context_of(b, t))
    assert np.abs(np.diff(sent[:, 0])).sum() < 2 * 5.0 + 0.5
    assert np.abs(sent[-25:, 0]).max() < 0.02
