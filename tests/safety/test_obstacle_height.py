"""Obstacles of known height are passed above and below, and never entered; those of unknown height stand in the way as ever."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array, Setpoint
from flightapp.safety.api import Guard, SafetyContext
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.altitude import AltitudeGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.obstacle_height import ObstacleHeightGuard
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.supervisor import Supervisor
from tests.safety.closed_loop import (
    ACCELERATION_M_S2,
    LAG_S,
    LIMITS,
    PARAMETERS,
    PERIOD_S,
    STEPS_A_PERIOD,
    Body,
    Wish,
    context_of,
    discs_at,
    setpoint_of,
)

BODY_M = LIMITS.body_radius_m
VERTICAL_M_S2 = PARAMETERS.vertical_acceleration_m_s2
STOP, HEIGHT = ObstacleStopGuard(PARAMETERS), ObstacleHeightGuard(PARAMETERS)
FLOOR_M, CEILING_M = 1.5, 15.0
place, rate = st.floats(-6, 6), st.floats(-2.5, 2.5)


def with_heights(discs: Array, *spans_m: tuple[float, float]) -> Array:
    """`discs` that reach from one height to another, each."""
    known = discs.copy()
    known[:, 5], known[:, 6] = [-top for _, top in spans_m], [-bottom for bottom, _ in spans_m]
    return known


def supervisor(*, heights: bool = True) -> Supervisor:
    finals: tuple[Guard, ...] = (AltitudeGuard(FLOOR_M, CEILING_M, PARAMETERS),)
    return Supervisor(
        stops=(FiniteGuard(),),
        limits=(SpeedGuard(),),
        spatial=(STOP,),
        rates=(AccelerationGuard(PARAMETERS),),
        finals=(HEIGHT, *finals) if heights else finals,
    )


def step(body: Body, sent: Array) -> list[Array]:
    """One control period of a vehicle with a lag of 0.25 s, at most 5 m/s2 in the plane and 2 m/s2 up and down."""
    passed, dt = [], PERIOD_S / STEPS_A_PERIOD
    for _ in range(STEPS_A_PERIOD):
        change = (sent - body.velocity) / LAG_S
        planar = math.hypot(change[0], change[1])
        change[:2] *= min(1.0, ACCELERATION_M_S2 / planar) if planar > 0.0 else 1.0
        change[2] = min(VERTICAL_M_S2, max(-VERTICAL_M_S2, change[2]))
        body.velocity = body.velocity + change * dt
        body.position = body.position + body.velocity * dt
        passed.append(body.position.copy())
    return passed


def flown(body: Body, wish: Wish, seconds: float, discs: Array, by: Supervisor, wrong_m: float = 0.0) -> Array:
    """Places (n, 3) passed through; the vehicle believes to be `wrong_m` higher than it is."""
    path = [body.position.copy()]
    for k in range(round(seconds / PERIOD_S)):
        wanted = Setpoint(wish(k * PERIOD_S, body), 0.0)
        told = context_of(body, k * PERIOD_S, discs=discs)
        believed = told.own.position_ned_m - np.array((0.0, 0.0, wrong_m))
        told = dataclasses.replace(told, own=dataclasses.replace(told.own, position_ned_m=believed))
        sent = by.check(wanted, told).setpoint
        body.previous = sent
        path += step(body, sent.velocity_ned_m_s)
    return np.array(path)


def steady(*velocity: float) -> Wish:
    return lambda _t, _b: np.array(velocity)


def least_m(path: Array, discs: Array) -> float:
    """Smallest distance of the body, an upright cylinder as high as it is wide, to the bodies of `discs`; negative inside."""
    beside = np.hypot(path[:, None, 0] - discs[:, 0], path[:, None, 1] - discs[:, 1]) - discs[:, 2] - BODY_M
    over = np.maximum(discs[:, 5] - path[:, None, 2], path[:, None, 2] - discs[:, 6]) - BODY_M
    return float(np.maximum(beside, over).min())


def scene(seed: int) -> tuple[Array, Array]:
    """Eight obstacles, most of known height, one of them hanging; and a free place."""
    random = np.random.default_rng(seed)
    discs = discs_at(*[(*random.uniform(-8, 8, 2), random.uniform(0.3, 1.2)) for _ in range(8)])
    discs[:7, 5], discs[:7, 6] = -random.uniform(2.0, 7.0, 7), 0.0
    discs[0, 5:] = -12.0, -random.uniform(6.0, 8.0)
    while True:
        start = np.array((*random.uniform(-8, 8, 2), -random.uniform(4.0, 11.0)))
        if least_m(start[None], discs) > PARAMETERS.obstacle_height_margin_m:
            return discs, start


def jumping(seed: int) -> Wish:
    """A wish that jumps each 0.8 s, with climbs and dives faster than the limits."""
    table = np.random.default_rng(seed).uniform((-8, -8, -3), (8, 8, 3), (10, 3))
    return lambda t_s, _: table[int(t_s / 0.8) % 10]


def diving_on(disc: Array) -> Wish:
    """Full speed to the middle of `disc` at 1.5 m above it, and from 2 m before it down."""

    def wish(_: float, body: Body) -> Array:
        offset = disc[:2] - body.position[:2]
        distance = math.hypot(*offset)
        down = 3.0 if distance < 2.0 else disc[5] - 1.5 - body.position[2]
        return np.array((*(offset * min(4.0 / max(distance, 1e-9), 2.0)), down))

    return wish


def test_nobody_enters_a_body_from_any_side_and_without_the_guards_many_do() -> None:
    hits = over = 0
    for seed in range(5):
        discs, start = scene(seed)
        for wish in (jumping(seed), diving_on(discs[1 + seed % 6])):
            path = flown(Body("p1", start.tolist()), wish, 7.0, discs, supervisor())
            assert least_m(path, discs) > 0.0, seed
            assert path[:, 2].max() <= -FLOOR_M
            assert path[:, 2].min() >= -CEILING_M
            over += int((np.hypot(path[:, None, 0] - discs[:, 0], path[:, None, 1] - discs[:, 1]) < discs[:, 2]).any())
        twin = flown(Body("p1", start.tolist()), diving_on(discs[1 + seed % 6]), 7.0, discs, supervisor(heights=False))
        hits += least_m(twin, discs) <= 0.0
    assert over >= 4
    assert hits >= 3


@pytest.mark.parametrize("wrong_m", [-0.4, 0.4])
def test_a_height_that_is_wrong_by_less_than_the_margin_keeps_the_body_clear(wrong_m: float) -> None:
    discs = with_heights(discs_at((8.0, 0.0, 1.5)), (0.0, 6.0))
    body = Body("p1", (0.0, 0.0, -8.0))
    path = flown(body, steady(2.0, 0.0, 2.0), 6.0, discs, supervisor(), wrong_m)
    assert least_m(path, discs) > 0.0


def crossed_m(discs: Array) -> float:
    """How far north a vehicle gets that flies straight on, 7 m high, at a wall across its way."""
    return float(flown(Body("p1", (0.0, 0.0, -7.0)), steady(4.0, 0.0, 0.0), 5.0, discs, supervisor())[:, 0].max())


def test_it_flies_over_a_wall_that_is_lower_and_with_the_height_unknown_it_stops_before_it() -> None:
    wall = discs_at(*[(8.0, east, 0.6) for east in np.arange(-20.0, 20.1, 0.8)])
    assert crossed_m(with_heights(wall, *[(0.0, 5.5)] * len(wall))) > 15.0
    assert crossed_m(with_heights(wall, *[(9.0, 14.0)] * len(wall))) > 15.0
    assert crossed_m(with_heights(wall, *[(0.0, 6.5)] * len(wall))) < 7.1, "within the margin it stands in the way"
    assert crossed_m(wall) < 7.1


def test_it_sinks_to_the_margin_above_what_it_flies_over_and_on_behind_it() -> None:
    discs = with_heights(discs_at((6.0, 0.0, 1.5)), (0.0, 6.0))
    path = flown(Body("p1", (6.0, 0.0, -10.0)), steady(0.0, 0.0, 2.0), 6.0, discs, supervisor())
    assert -path[-1, 2] == pytest.approx(6.0 + BODY_M + PARAMETERS.obstacle_height_margin_m, abs=0.1)
    path = flown(Body("p1", (6.0, 0.0, -8.0)), steady(2.0, 0.0, 1.0), 8.0, discs, supervisor())
    assert least_m(path, discs) > 0.0
    assert -path[-1, 2] < 2.0


@pytest.mark.parametrize(("away_m", "above_m", "speed_m_s"), [(2.0, 0.5, 3.0), (1.2, 0.5, 5.0), (0.6, 0.8, 5.0), (2.0, 1.1, 5.0)])
def test_who_dives_on_the_last_metres_before_the_edge_is_kept_above(away_m: float, above_m: float, speed_m_s: float) -> None:
    discs = with_heights(discs_at((6.0, 0.0, 1.5)), (0.0, 6.0))
    body = Body("p1", (6.0 - 1.5 - BODY_M - away_m, 0.0, -(6.0 + BODY_M + above_m)), (speed_m_s, 0.0, 0.0))
    body.previous = setpoint_of(speed_m_s, 0.0)
    assert least_m(flown(body, steady(speed_m_s, 0.0, 3.0), 3.0, discs, supervisor()), discs) > 0.1


def test_who_is_pressed_down_on_an_obstacle_is_brought_up_and_the_fence_has_the_last_word() -> None:
    discs = with_heights(discs_at((0.0, 0.0, 1.5)), (0.0, 6.0))
    pressed = Body("p1", (0.0, 0.0, -6.5))
    up = HEIGHT.check(setpoint_of(0.0, 0.0, 1.0), context_of(pressed, discs=discs))
    assert up.setpoint.velocity_ned_m_s[2] < 0.0
    assert "above an obstacle" in up.reason
    high = with_heights(discs_at((0.0, 0.0, 1.5)), (0.0, CEILING_M - 0.2))
    last = supervisor().check(setpoint_of(0.0, 0.0), context_of(Body("p1", (0.0, 0.0, -CEILING_M - 0.3)), discs=high)).setpoint
    assert last.velocity_ned_m_s[2] > 0.0, "the band goes before"


@settings(max_examples=60, deadline=None)
@given(place, place, st.floats(0.2, 2), st.floats(0, 12), st.floats(0.5, 6), st.floats(1, 14), *[rate] * 6)
def test_an_unknown_height_is_at_least_as_strict_in_the_plane_and_no_wish_is_made_less_safe_up_or_down(
    n: float, e: float, radius: float, bottom: float, tall: float, height: float,
    vn: float, ve: float, vd: float, wn: float, we: float, wd: float,
) -> None:  # fmt: skip
    unknown = discs_at((n, e, radius))
    known = with_heights(unknown, (bottom, bottom + tall))
    body = Body("p1", (0.0, 0.0, -height), (2 * vn, 2 * ve, vd))

    def asked(discs: Array) -> tuple[list[object], Array]:
        context = context_of(body, discs=discs)
        bounds: list[object] = [*STOP.bounds((2 * wn, 2 * we), 9.0, context)]
        return bounds, HEIGHT.check(setpoint_of(2 * wn, 2 * we, wd), context).setpoint.velocity_ned_m_s

    known_bounds, known_sent = asked(known)
    unknown_bounds, unknown_sent = asked(unknown)
    assert known_bounds in ([], unknown_bounds)
    assert unknown_sent.tolist() == [2 * wn, 2 * we, wd]
    assert known_sent[:2].tolist() == [2 * wn, 2 * we]
    on_top = np.hypot(n, e) < radius + BODY_M + 0.2
    if known_sent[2] != wd and not on_top:
        assert known_sent[2] * wd >= 0.0
        assert abs(known_sent[2]) < abs(wd)
    if not known_bounds and unknown_bounds:
        gap = max(height - bottom - tall, bottom - height) - BODY_M
        assert gap >= 0.5 * PARAMETERS.obstacle_height_margin_m - 1e-9


def untrusted(context: SafetyContext, **changes: object) -> SafetyContext:
    return dataclasses.replace(context, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize("changes", [{"heights_trusted": False}, {"own_age_s": 0.5}, {"obstacles_age_s": 1.0}])
def test_heights_that_cannot_be_trusted_relax_nothing(changes: dict[str, object]) -> None:
    low = with_heights(discs_at((3.0, 0.0, 0.5)), (0.0, 4.0))
    context = context_of(Body("p1", (0.0, 0.0, -8.0), (4.0, 0.0, 0.0)), discs=low)
    assert STOP.bounds((4.0, 0.0), 5.0, context) == []
    unknown = dataclasses.replace(context, obstacles=dataclasses.replace(context.obstacles, discs=discs_at((3.0, 0.0, 0.5))))
    doubted = STOP.bounds((4.0, 0.0), 5.0, untrusted(context, **changes))
    assert doubted
    assert doubted == STOP.bounds((4.0, 0.0), 5.0, untrusted(unknown, **changes))


@pytest.mark.parametrize(("top", "bottom"), [(0.0, -4.0), (math.nan, 0.0), (-math.inf, 0.0), (-math.inf, math.inf)])
def test_heights_that_make_no_sense_are_unknown_ones_and_who_moves_is_not_flown_over(top: float, bottom: float) -> None:
    discs = discs_at((3.0, 0.0, 0.5))
    body = Body("p1", (0.0, 0.0, -8.0), (4.0, 0.0, 0.0))
    stopped = STOP.bounds((4.0, 0.0), 5.0, context_of(body, discs=discs))
    odd = discs.copy()
    odd[0, 5:] = top, bottom
    assert STOP.bounds((4.0, 0.0), 5.0, context_of(body, discs=odd)) == stopped
    walker = with_heights(discs, (0.0, 2.0))
    walker[0, 3] = -1.0
    assert STOP.bounds((4.0, 0.0), 5.0, context_of(body, discs=walker))
