"""Closed loops of the guards that have no scene of their own elsewhere, each beside its twin with that guard left out."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.clearance import clearance_m
from flightapp.core.types import Setpoint
from flightapp.safety.api import Guard, SafetyContext
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.obstacle_stop import ObstacleStopGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.guards.unseen_sector import UnseenSectorGuard
from flightapp.safety.guards.yaw_rate import YawRateGuard
from flightapp.safety.supervisor import Supervisor
from tests.safety.closed_loop import LIMITS, PARAMETERS, PERIOD_S, Body, context_of, discs_at, fly

AHEAD = np.array([[-math.pi / 4, math.pi / 4]])
SEEN_M = 2.0
"""How near a thing must be until it is seen from the edge of an unseen sector."""


def supervisor(*, limits: tuple[Guard, ...] = (), rates: tuple[Guard, ...] = (), obstacles: bool = False) -> Supervisor:
    spatial = (ObstacleStopGuard(PARAMETERS),) if obstacles else ()
    unlimited = SpeedGuard(math.inf)
    return Supervisor(stops=(FiniteGuard(),), limits=limits, spatial=spatial, rates=rates, finals=(), speed=unlimited)


def top_speed_m_s(*, guarded: bool) -> float:
    chosen = supervisor(limits=(SpeedGuard(),) if guarded else ())
    path, _ = fly(Body("p1", (0, 0)), lambda t, b: np.array([20.0, 10.0, 0.0]), chosen, 4, lambda t, b: context_of(b, t))
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).max() / (PERIOD_S / 4))


def test_speed_stays_within_its_limit_and_its_twin_does_not() -> None:
    assert top_speed_m_s(guarded=True) <= LIMITS.speed_max_m_s + 1e-6
    assert top_speed_m_s(guarded=False) > 2 * LIMITS.speed_max_m_s


def largest_turn_rad(*, guarded: bool) -> float:
    """Between two setpoints in a row, of a planner that wants to look back and forth."""
    chosen = supervisor(rates=(YawRateGuard(),) if guarded else ())
    body, yaws = Body("p1", (0, 0)), [0.0]
    for step in range(100):
        wish = Setpoint(np.zeros(3), math.pi * (step // 10 % 2))
        sent = chosen.check(wish, context_of(body, step * PERIOD_S)).setpoint
        body.fly(sent)
        yaws.append(sent.yaw_rad)
    return float(np.abs(np.angle(np.exp(1j * np.diff(yaws)))).max())


def test_the_nose_turns_no_faster_than_it_may_and_its_twin_jumps() -> None:
    assert largest_turn_rad(guarded=True) <= LIMITS.yaw_rate_max_rad_s * PERIOD_S + 1e-9
    assert largest_turn_rad(guarded=False) > 1.0


def clearance_of_what_was_not_seen_m(*, guarded: bool) -> float:
    """To a tree in a sector in which nothing was observed; it becomes known from SEEN_M."""
    tree, body = discs_at((8.0, 0.0, 0.5)), Body("p1", (0, 0))
    limits: tuple[Guard, ...] = (SpeedGuard(), UnseenSectorGuard(PARAMETERS)) if guarded else (SpeedGuard(),)
    chosen = supervisor(limits=limits, rates=(AccelerationGuard(PARAMETERS),), obstacles=True)

    def situation(t_s: float, own: Body) -> SafetyContext:
        near = clearance_m(own.position[:2], tree, LIMITS.body_radius_m) < SEEN_M
        return context_of(own, t_s, discs=tree if near else tree[:0], unseen=AHEAD)

    path, _ = fly(body, lambda t, b: np.array([5.0, 0.0, 0.0]), chosen, 8, situation)
    return min(clearance_m(point[:2], tree, LIMITS.body_radius_m) for point in path)


def test_into_the_unseen_one_flies_so_slowly_that_one_can_stop_and_the_twin_hits() -> None:
    assert clearance_of_what_was_not_seen_m(guarded=True) > 0.0
    assert clearance_of_what_was_not_seen_m(guarded=False) < 0.0


def clearance_of_who_comes_m(*, guarded: bool, aside_m: float) -> float:
    """To a person who walks at a vehicle that wants to go on; what remains when they have passed each other."""
    chosen = supervisor(limits=(SpeedGuard(),), rates=(AccelerationGuard(PARAMETERS),), obstacles=guarded)
    least = math.inf

    def situation(t_s: float, own: Body) -> SafetyContext:
        nonlocal least
        person = discs_at((12.0 - 1.5 * t_s, aside_m, 0.3))
        person[:, 3] = -1.5
        least = min(least, clearance_m(own.position[:2], person, LIMITS.body_radius_m))
        return context_of(own, t_s, discs=person)

    fly(Body("p1", (0, 0)), lambda t, b: np.array([3.0, 0.0, 0.0]), chosen, 6, situation)
    return least


@pytest.mark.parametrize("aside_m", [0.05, 0.1, 0.3, -0.2])
def test_who_walks_towards_the_vehicle_is_passed_and_by_the_twin_is_hit(aside_m: float) -> None:
    assert clearance_of_who_comes_m(guarded=True, aside_m=aside_m) > 0.05
    assert clearance_of_who_comes_m(guarded=False, aside_m=aside_m) < 0.0
