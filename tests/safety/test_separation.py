from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array, Setpoint, TeamMember
from flightapp.safety.api import SafetyContext
from flightapp.safety.guards.separation import SeparationGuard
from flightapp.safety.guards.speed import SpeedGuard
from tests.safety.closed_loop import (
    LIMITS,
    PARAMETERS,
    PERIOD_S,
    Body,
    Wish,
    context_of,
    member_of,
    random_wishes,
    setpoint_of,
    supervisor_of,
    towards,
)

GUARD = SeparationGuard(PARAMETERS)
place = st.floats(-8, 8)
speed = st.floats(-5, 5)


def _fly_together(bodies: list[Body], wishes: list[Wish], guarded: list[bool], seconds: float) -> float:
    """Smallest distance between any two; each vehicle hears of the others one control period late."""
    supervisors = [supervisor_of(separation=SeparationGuard(PARAMETERS)) for _ in bodies]
    heard = [body.state(0.0) for body in bodies]
    least = math.inf
    for step in range(round(seconds / PERIOD_S)):
        t_s = step * PERIOD_S
        sent = []
        for index, body in enumerate(bodies):
            team = tuple(TeamMember(o.name, heard[i], "", None, PERIOD_S) for i, o in enumerate(bodies) if i != index)
            context = context_of(body, t_s, team=team)
            wish = Setpoint(wishes[index](t_s, body), 0.0)
            guard = supervisors[index] if guarded[index] else SpeedGuard()
            sent.append(guard.check(wish, context).setpoint)
        heard = [body.state(t_s) for body in bodies]
        paths = np.array([body.fly(setpoint) for body, setpoint in zip(bodies, sent, strict=True)])[..., :2]
        for i in range(len(bodies)):
            for j in range(i):
                least = min(least, float(np.linalg.norm(paths[i] - paths[j], axis=1).min()))
    return least


def _starts(seed: int, count: int = 2) -> list[Body]:
    rng = np.random.default_rng(seed)
    while True:
        places = rng.uniform(-8, 8, (count, 2))
        if all(np.linalg.norm(places[i] - places[j]) > 1.8 for i in range(count) for j in range(i)):
            return [Body(f"p{index + 1}", place) for index, place in enumerate(places)]


@pytest.mark.parametrize("guarded", [[True, True], [True, False], [False, True]], ids=["both", "lower name", "higher name"])
def test_two_vehicles_stay_apart_also_when_only_one_knows(guarded: list[bool]) -> None:
    for seed in range(5):
        points = np.random.default_rng(seed).uniform(-1, 1, (2, 2))
        for wishes in ([random_wishes(seed), random_wishes(seed + 99)], [towards(points[0]), towards(points[1])]):
            assert _fly_together(_starts(seed), wishes, guarded, 5) >= PARAMETERS.separation_min_m


def test_without_the_guard_they_come_too_close() -> None:
    too_close = 0
    for seed in range(5):
        points = np.random.default_rng(seed).uniform(-1, 1, (2, 2))
        least = _fly_together(_starts(seed), [towards(points[0]), towards(points[1])], [False, False], 5)
        too_close += least < PARAMETERS.separation_min_m
    assert too_close == 5


@pytest.mark.parametrize("offset", [0.0, 0.02, 0.5])
@pytest.mark.parametrize("guarded", [[True, True], [True, False], [False, True]], ids=["both", "lower name", "higher name"])
def test_head_on_they_pass_and_arrive(offset: float, guarded: list[bool]) -> None:
    bodies = [Body("p1", (-9.0, offset)), Body("p2", (9.0, 0.0))]
    least = _fly_together(bodies, [towards((9.0, 0.0)), towards((-9.0, offset))], guarded, 15)
    assert least >= PARAMETERS.separation_min_m
    assert np.allclose(bodies[0].position[:2], (9.0, 0.0), atol=0.3)
    assert np.allclose(bodies[1].position[:2], (-9.0, offset), atol=0.3)


@pytest.mark.parametrize("standing", ["p1", "p9"])
def test_a_standing_teammate_is_passed(standing: str) -> None:
    bodies = [Body("p5", (-7.0, 0.0)), Body(standing, (0.0, 0.0))]
    least = _fly_together(bodies, [towards((7.0, 0.0)), towards((0.0, 0.0))], [True, True], 10)
    assert least >= PARAMETERS.separation_min_m
    assert np.allclose(bodies[0].position[:2], (7.0, 0.0), atol=0.3)


def test_four_vehicles_that_swap_places_all_arrive() -> None:
    ring = [(8.0 * math.cos(a), 8.0 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 5)[:-1]]
    bodies = [Body(f"p{index}", where) for index, where in enumerate(ring)]
    goals = [(-north, -east) for north, east in ring]
    assert _fly_together(bodies, [towards(goal) for goal in goals], [True] * 4, 20) >= PARAMETERS.separation_min_m
    for body, goal in zip(bodies, goals, strict=True):
        assert np.allclose(body.position[:2], goal, atol=0.3)


def test_capture_positions_opposite_the_evader_are_not_disturbed() -> None:
    body = Body("p1", (0.0, 0.0))
    for north in (-0.5, 0.5):
        verdict = GUARD.check(setpoint_of(north, 0.3), context_of(body, team=(member_of(Body("p2", (4.4, 0.0)), 0.05),)))
        assert verdict.reason == ""


def test_a_stale_teammate_is_widened_but_not_for_ever() -> None:
    other = Body("p2", (6.0, 0.0), (2.0, 0.0, 0.0))
    body = Body("p1", (0.0, 0.0))
    fresh, old, ancient = (
        GUARD.rules((5.0, 0.0), context_of(body, team=(member_of(other, age),)))[0] for age in (0.1, 0.9, 60.0)
    )
    assert fresh.gap_m > old.gap_m > ancient.gap_m
    kept = PARAMETERS.separation_min_m + PARAMETERS.separation_buffer_m
    assert old.gap_m == pytest.approx(6.0 - kept - 0.9 * 2.0)
    assert ancient.gap_m == pytest.approx(6.0 - kept - PARAMETERS.team_widening_max_m)
    assert ancient.bound.bound_m_s >= 0.0


@settings(max_examples=200, deadline=None)
@given(place, place, speed, speed, speed, speed, speed, speed, st.floats(0, 3))
def test_never_closes_faster(
    n: float, e: float, tn: float, te: float, vn: float, ve: float, wn: float, we: float, age_s: float
) -> None:
    other = Body("p2", (n, e), (tn, te, 0.0))
    context = context_of(Body("p1", (0, 0), (vn, ve, 0.0)), team=(member_of(other, age_s),))
    out = GUARD.check(setpoint_of(wn, we, 0.1, 1.0), context).setpoint.velocity_ned_m_s
    distance = max(math.hypot(n, e), 1e-9)
    closing_in, closing_out = (wn * n + we * e) / distance, (out[0] * n + out[1] * e) / distance
    # At top speed a step aside can only be taken out of the retreat: a little of it.
    given_up = 0.02 * LIMITS.speed_max_m_s if math.hypot(wn, we) > 0.98 * LIMITS.speed_max_m_s else 1e-6
    if distance > 1e-3:
        assert closing_out <= closing_in + given_up
        if distance <= PARAMETERS.separation_min_m:
            assert closing_out <= 1e-6
    assert out[2] == 0.1
    turned = GUARD.give_way((wn, we), GUARD.rules((wn, we), context))
    assert math.hypot(*turned) <= math.hypot(wn, we) + 1e-6
    if distance > 1e-3:
        assert (turned[0] * n + turned[1] * e) / distance <= closing_in + 1e-6


def test_who_is_elsewhere_does_not_count() -> None:
    body, other = Body("p1", (0, 0)), Body("p2", (1.0, 0.0))
    other.position[2] = -9.0
    assert GUARD.rules((0.0, 0.0), context_of(body, team=(member_of(other),))) == []
    assert GUARD.rules((0.0, 0.0), context_of(body, team=(member_of(Body("p1", (0.1, 0.0))),))) == []
    assert SeparationGuard(PARAMETERS, ["p3"]).rules((0.0, 0.0), _context(body, Body("p2", (1.0, 0.0)))) == []
    assert (
        LIMITS.speed_max_m_s
        >= -GUARD.rules((0.0, 0.0), context_of(body, team=(member_of(Body("p2", (1, 0), (-30, 0, 0))),)))[0].bound.bound_m_s
    )


def test_in_the_same_place_each_goes_its_own_way() -> None:
    first, second = Body("p1", (0, 0)), Body("p2", (0, 0))
    one = GUARD.rules((0.0, 0.0), context_of(first, team=(member_of(second),)))[0].bound
    two = GUARD.rules((0.0, 0.0), context_of(second, team=(member_of(first),)))[0].bound
    assert (one.north, one.east) == (-two.north, -two.east)


def _context(body: Body, other: Body, age_s: float = 0.06) -> SafetyContext:
    return context_of(body, team=(member_of(other, age_s),))


@pytest.mark.parametrize(
    ("offset", "theirs"),
    [((0.0, 2.3), (5.0, 0.0, 0.0)), ((3.0, 3.0), (-5.0, 0.0, 0.0)), ((3.0, 5.0), (5.0, -3.5, 0.0))],
    ids=["abreast", "oncoming, passed with room", "behind its back"],
)
def test_parallel_flight_and_passing_with_room_are_not_disturbed(
    offset: tuple[float, float], theirs: tuple[float, float, float]
) -> None:
    body, other = Body("p1", (0.0, 0.0), (5.0, 0.0, 0.0)), Body("p2", offset, theirs)
    assert GUARD.check(setpoint_of(5.0, 0.0), _context(body, other)).reason == ""


def test_a_stale_teammate_is_never_passed_by_prediction() -> None:
    body, other = Body("p1", (0.0, 0.0), (5.0, 0.0, 0.0)), Body("p2", (3.0, 4.0), (-5.0, 0.0, 0.0))
    assert GUARD.check(setpoint_of(5.0, 0.0), _context(body, other)).reason == ""
    assert GUARD.check(setpoint_of(5.0, 0.0), _context(body, other, 1.1)).reason != ""


def test_a_wish_or_a_motion_that_meets_the_teammate_is_bounded() -> None:
    other = Body("p2", (2.5, 0.0))
    past, at_it = setpoint_of(0.0, 5.0), setpoint_of(5.0, 0.0)
    assert GUARD.check(past, _context(Body("p1", (0.0, 0.0), (0.0, 5.0, 0.0)), other)).reason == ""
    assert GUARD.check(at_it, _context(Body("p1", (0.0, 0.0), (0.0, 5.0, 0.0)), other)).reason != ""
    assert GUARD.check(at_it, _context(Body("p1", (0.0, 0.0), (5.0, 0.0, 0.0)), other)).reason != ""


def test_a_narrow_pass_is_widened_and_not_braked() -> None:
    other = Body("p2", (6.0, 1.5))
    out = GUARD.check(setpoint_of(5.0, 0.0), _context(Body("p1", (0.0, 0.0), (5.0, 0.0, 0.0)), other)).setpoint
    north, east, _ = out.velocity_ned_m_s
    assert north > 4.0
    assert east < 0.0


def _chase(bodies: list[Body], index: int, seed: int) -> Wish:
    """At full speed at the other vehicle, with random spells in between."""
    random = random_wishes(seed)

    def wish(t_s: float, body: Body) -> Array:
        if (int(t_s / 0.8) + seed) % 3 == 0:
            return random(t_s, body)
        offset = (bodies[1 - index].position - body.position) * (1.0, 1.0, 0.0)
        return offset * (6.0 / max(float(np.linalg.norm(offset)), 1e-6))

    return wish


@pytest.mark.parametrize("seed", range(6))
def test_two_that_fly_at_each_other_from_fast_starts_stay_apart(seed: int) -> None:
    bodies = _starts(seed)
    for body, velocity in zip(bodies, np.random.default_rng(seed).uniform(-1.5, 1.5, (2, 2)), strict=True):
        body.velocity = np.array([*velocity, 0.0])
    wishes = [_chase(bodies, 0, seed), _chase(bodies, 1, seed + 50)]
    assert _fly_together(bodies, wishes, [True, True], 5) >= PARAMETERS.separation_min_m
