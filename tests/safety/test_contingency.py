from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from flightapp.core.types import Array, Setpoint
from flightapp.safety.api import Action, Demand
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.altitude import AltitudeGuard
from flightapp.safety.guards.contingency import ContingencyGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.geofence import GeofenceGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.supervisor import Supervisor
from tests.safety.closed_loop import PARAMETERS, PERIOD_S, Body, context_of, noisy, setpoint_of

SQUARE = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
NOTCHED = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (2.0, 10.0), (2.0, 0.0), (-2.0, 0.0), (-2.0, 10.0), (-10.0, 10.0))
TOP_M, AROUND_M, ABOVE_M = 20.0, 5.0, 4.0


def _guard(vertices: tuple[tuple[float, float], ...] = SQUARE, **changes: object) -> ContingencyGuard:
    return ContingencyGuard(vertices, TOP_M, **{"contingency_m": AROUND_M, "contingency_height_m": ABOVE_M, **changes})


def _supervisor(vertices: tuple[tuple[float, float], ...], guarded: bool = True) -> Supervisor:
    guard = _guard(vertices)
    return Supervisor(
        stops=(FiniteGuard(),),
        limits=(SpeedGuard(), guard) if guarded else (SpeedGuard(),),
        spatial=(GeofenceGuard(vertices, PARAMETERS),) if guarded else (),
        rates=(AccelerationGuard(PARAMETERS),),
        finals=(AltitudeGuard(1.5, TOP_M, PARAMETERS),) if guarded else (),
        watches=(guard,),
    )


class Flight:
    """Positions (n, 3), setpoint velocities (n, 3) and demands, one a period, of an own position with noise of 0.1 m."""

    def __init__(self, body: Body, wish: Array, supervisor: Supervisor, seconds: float, seed: int = 0) -> None:
        random = np.random.default_rng(seed)
        path, sent, self.demands = [], [], []
        for step in range(round(seconds / PERIOD_S)):
            context = noisy(context_of(body, step * PERIOD_S), random)
            supervised = supervisor.check(Setpoint(wish, 0.0), context)
            body.fly(supervised.setpoint)
            path.append(body.position.copy())
            sent.append(supervised.setpoint.velocity_ned_m_s)
            self.demands.append(supervised.demand)
        self.path, self.sent = np.array(path), np.array(sent)

    @property
    def actions(self) -> list[Action | None]:
        """The demanded actions in their order, each change once."""
        actions = [None if demand is None else demand.action for demand in self.demands]
        return [action for index, action in enumerate(actions) if index == 0 or action != actions[index - 1]]


heading = st.floats(-math.pi, math.pi)


@pytest.mark.parametrize("vertices", [SQUARE, NOTCHED], ids=["square", "notched"])
@settings(max_examples=25, deadline=None)
@given(heading, heading, heading, st.floats(0, 8), st.floats(-14, 14), st.floats(-14, 14))
def test_whoever_is_outside_comes_back_and_stays_whatever_it_wishes(
    vertices: tuple[tuple[float, float], ...], motion: float, wish: float, wind: float, speed: float, north: float, east: float
) -> None:
    polygon, outward = Polygon(vertices), np.array([5 * math.cos(wish), 5 * math.sin(wish), -2.0])
    blows = (speed * math.cos(wind), speed * math.sin(wind), 0.0)
    flight = Flight(
        Body("p1", (north, east), (math.cos(motion), math.sin(motion), 0.0), blows), outward, _supervisor(vertices), 16
    )
    settled = flight.path[-100:]
    assert all(polygon.contains(Point(p[:2])) for p in settled)
    assert (-settled[:, 2] < TOP_M).all()
    assert flight.sent[:, :2].max() <= 5.0 + 1e-6
    assert len(flight.actions) <= 5
    assert flight.demands[-1] is None or flight.demands[-1].action >= Action.LAND


def test_its_twin_without_fence_leaves_the_contingency_volume_and_is_told_to_land() -> None:
    wish = np.array([5.0, 1.0, 0.0])
    twin = Flight(Body("p1", (8.0, 0.0)), wish, _supervisor(SQUARE, guarded=False), 8)
    assert twin.path[-1, 0] > 10.0 + AROUND_M
    assert twin.actions == [None, Action.HOLD, Action.LAND]
    safe = Flight(Body("p1", (8.0, 0.0)), wish, _supervisor(SQUARE), 8)
    assert safe.path[:, 0].max() < 10.0
    assert safe.actions == [None]


@pytest.mark.parametrize("place", [(9.75, 0.0), (9.75, 9.75), (2.25, 5.0), (10.0, 10.0), (-2.0, 0.0), (11.0, 0.0), (0.0, 5.0)])
@pytest.mark.parametrize("blowing", [-8.0, 0.0, 8.0])
def test_noise_at_the_border_makes_no_limit_cycle(place: tuple[float, float], blowing: float) -> None:
    """Pressed against the fence with 0.1 m of noise and 8 m/s of wind the vehicle comes to rest inside it."""
    wish = np.array([4.0, 4.0, 0.0])
    flight = Flight(Body("p1", place, wind_m_s=(blowing, blowing, 0.0)), wish, _supervisor(NOTCHED), 20)
    settled = flight.path[-200:, :2]
    assert np.ptp(settled, axis=0).max() < 0.25
    assert all(Polygon(NOTCHED).contains(Point(p)) for p in settled)
    assert len(flight.actions) <= 3
    assert flight.demands[-1] is None


def test_the_hold_sets_in_steadily_and_keeps_height_and_yaw() -> None:
    for beyond, scale in [(-0.1, 1.0), (0.25, 0.75), (0.5, 0.5), (3.0, 0.0)]:
        verdict = _guard().check(setpoint_of(-2.0, 1.0, 0.5, 0.7), context_of(Body("p1", (10.0 + beyond, 0.0))))
        assert verdict.setpoint.velocity_ned_m_s.tolist() == pytest.approx([-2.0 * scale, scale, 0.5])
        assert verdict.setpoint.yaw_rad == 0.7
        assert (verdict.reason == "") == (scale == 1.0)


def _demands(guard: ContingencyGuard, position: tuple[float, float, float], seconds: float) -> Demand | None:
    body = Body("p1", position)
    body.position[:] = position
    for _ in range(round(seconds / PERIOD_S)):
        demand = guard.demand(context_of(body))
    return demand


@pytest.mark.parametrize(
    ("position", "action"),
    [
        ((0.0, 0.0, -5.0), None),
        ((12.0, 0.0, -5.0), Action.HOLD),
        ((0.0, 0.0, -TOP_M - 1.0), Action.HOLD),
        ((0.0, 0.0, -0.2), None),
        ((15.5, 0.0, -5.0), Action.TERMINATE),
        ((14.0, 14.0, -5.0), Action.TERMINATE),
        ((0.0, 0.0, -TOP_M - ABOVE_M - 0.5), Action.TERMINATE),
    ],
)
def test_what_is_asked_for_where(position: tuple[float, float, float], action: Action | None) -> None:
    demand = _demands(_guard(outside_action=Action.TERMINATE), position, 0.4)
    assert (None if demand is None else demand.action) == action
    if demand is not None:
        assert demand.guard == "contingency"
        assert "flight volume" in demand.reason


def test_a_polygon_of_its_own_replaces_the_distance() -> None:
    guard = _guard(contingency_vertices_m=((-11.0, -11.0), (30.0, -11.0), (30.0, 11.0), (-11.0, 11.0)))
    assert _demands(guard, (25.0, 0.0, -5.0), 0.4).action == Action.HOLD
    assert _demands(guard, (-12.0, 0.0, -5.0), 0.4).action == Action.LAND


def test_one_wrong_position_asks_for_nothing_and_an_end_is_never_taken_back() -> None:
    guard = _guard()
    for _ in range(20):
        assert _demands(guard, (40.0, 0.0, -5.0), PERIOD_S) is None
        assert _demands(guard, (0.0, 0.0, -5.0), PERIOD_S) is None
    ended = _demands(guard, (40.0, 0.0, -5.0), 0.3)
    assert ended.action == Action.LAND
    assert _demands(guard, (0.0, 0.0, -5.0), 60.0) == ended
    assert _demands(guard, (math.nan, 0.0, -5.0), 1.0) == ended


def test_a_hold_ends_after_a_second_inside() -> None:
    guard = _guard()
    assert _demands(guard, (11.0, 0.0, -5.0), 0.4).action == Action.HOLD
    assert _demands(guard, (9.9, 0.0, -5.0), 0.9).action == Action.HOLD
    assert _demands(guard, (9.9, 0.0, -5.0), 0.2) is None
