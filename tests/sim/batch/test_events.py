"""What ends an episode is found between samples, in the order in which it happens."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.clearance import closest_approach_m
from flightapp.core.types import Boundary
from flightapp.planning.boundary import NEVER, crossing
from flightapp.planning.plane import crosses
from flightapp.sim.batch.contact import first_within
from flightapp.sim.batch.families.layout import Start, disc
from flightapp.sim.batch.records import CAPTURED, COLLIDED, ESCAPED, FLYING, VEHICLE
from flightapp.sim.batch.surrounding import encircles
from tests.planning.capture_reference import encircled
from tests.sim.batch.stubs import command, scenario, set_moving, world

COARSE = scenario(pursuers__count=1, sub_step_s=0.1)
PLACE = st.floats(-20.0, 20.0).map(lambda value: round(value, 3))


@settings(max_examples=150, deadline=None)
@given(PLACE, PLACE, PLACE, PLACE, st.floats(0.05, 15.0))
def test_first_contact_is_where_the_distance_first_falls_to_the_reach(
    an: float, ae: float, bn: float, be: float, reach: float
) -> None:
    start, end = np.array((an, ae)), np.array((bn, be))
    closest, _ = closest_approach_m(start, end)
    first = first_within(an, ae, bn, be, reach)
    if abs(closest - reach) < 1e-6:
        return
    if closest > reach:
        assert first == NEVER
    elif math.hypot(an, ae) <= reach:
        assert first == 0.0
    else:
        assert np.linalg.norm(start + first * (end - start)) == pytest.approx(reach, abs=1e-6)
        assert closest_approach_m(start, start + 0.999 * first * (end - start))[0] > reach


@settings(max_examples=150, deadline=None)
@given(st.tuples(*[PLACE] * 8))
def test_crossing_agrees_with_the_planners_rule(places: tuple[float, ...]) -> None:
    p, q, a, b = zip(places[::2], places[1::2], strict=True)
    where = crossing(*p, *q, *a, *b)
    assert (where <= 1.0) == crosses(p, q, [(a, b)])
    if where <= 1.0:
        met = np.array(p) + where * (np.array(q) - np.array(p))
        side = np.array(b) - np.array(a)
        off = abs(side[0] * (met[1] - a[1]) - side[1] * (met[0] - a[0])) / max(1e-9, float(np.hypot(*side)))
        assert off < 1e-6 or np.hypot(*side) < 1e-6


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)), min_size=1, max_size=5))
def test_encirclement_agrees_with_the_planners_rule(places: list[tuple[float, float]]) -> None:
    rule = scenario("a2-encircle").capture
    vehicles = np.zeros(len(places) + 1, VEHICLE)
    vehicles["n"][:-1], vehicles["e"][:-1] = zip(*places, strict=True)
    assert encircles(vehicles, rule.zone_m, rule.angular_gap_min_deg) == encircled((0.0, 0.0), places, rule)


def test_capture_between_two_samples_is_found() -> None:
    """They pass at 10 m/s with 0.3 m between them; at no sample are they nearer than 0.5 m."""
    passing = world(COARSE, [Start(0.0, 0.3, 0.0)], Start(1.0, 0.0, math.pi), [])
    set_moving(passing, 0, 6.0, 0.0)
    set_moving(passing, 1, -4.0, 0.0)
    passing.vehicles[0]["n"] = 0.5
    assert passing.advance(0, [command(6.0, 0.0), command(-4.0, 0.0)]) == CAPTURED
    assert float(passing.record["end_s"][0]) == pytest.approx((0.5 - math.sqrt(0.4**2 - 0.3**2)) / 10.0)


def test_moving_disc_hits_a_vehicle_that_stands() -> None:
    stands = world(scenario(pursuers__count=1), [Start(0.0, 0.0, 0.0)], Start(50.0, 50.0, 0.0), [disc(3.0, 0.0, 0.5, -2.0, 0.0)])
    outcomes = [stands.advance(tick, [command(0.0, 0.0, 0.0)] * 2) for tick in range(12)]
    assert outcomes[:11] == [FLYING] * 11
    assert outcomes[11] == COLLIDED
    assert stands.collided_with == "obstacle"
    assert float(stands.record["end_s"][0]) == pytest.approx((3.0 - 0.75) / 2.0, abs=1e-6)
    assert float(stands.record["clearance"][0]) == pytest.approx(0.0, abs=1e-9)


def test_moving_disc_turns_round_at_the_edge_of_the_area() -> None:
    """Away from the vehicle to the edge at 100 m and back."""
    stands = world(scenario(pursuers__count=1), [Start(97.0, 0.0, 0.0)], Start(0.0, 50.0, 0.0), [disc(99.0, 0.0, 0.5, 2.0, 0.0)])
    for tick in range(30):
        if stands.advance(tick, [command(0.0, 0.0, 0.0)] * 2) != FLYING:
            break
    assert float(stands.record["end_s"][0]) == pytest.approx((1.0 + 3.0 - 0.75) / 2.0, abs=1e-6)


def test_collision_before_capture_within_one_step_is_a_collision() -> None:
    thin = [disc(0.6, 0.0, 0.05)]
    blocked = world(COARSE, [Start(0.0, 0.0, 0.0)], Start(1.1, 0.0, 0.0), thin)
    set_moving(blocked, 0, 6.0, 0.0)
    set_moving(blocked, 1, -4.0, 0.0)
    assert blocked.advance(0, [command(6.0, 0.0), command(-4.0, 0.0)]) == COLLIDED
    assert float(blocked.record["end_s"][0]) == pytest.approx(0.3 / 6.0)


def test_teammates_that_touch_have_collided() -> None:
    pair = world(scenario(), [Start(0.0, 0.0, 0.0), Start(2.0, 0.0, math.pi)], Start(50.0, 50.0, 0.0), [])
    set_moving(pair, 0, 2.0, 0.0)
    set_moving(pair, 1, -2.0, 0.0)
    outcomes = [pair.advance(tick, [command(2.0, 0.0), command(-2.0, 0.0), command(0.0, 0.0, 0.0)]) for tick in range(4)]
    assert outcomes[-1] == COLLIDED
    assert pair.collided_with == "teammate"
    assert float(pair.record["end_s"][0]) == pytest.approx(1.5 / 4.0, abs=1e-6)
    assert float(pair.record["separation"][0]) == pytest.approx(0.5, abs=1e-6)


def test_evader_that_crosses_a_closed_boundary_has_escaped() -> None:
    fence = Boundary(np.array([[-1.0, -1.0], [-1.0, 1.0], [-3.0, 0.0]]), True)
    runs = world(scenario(pursuers__count=1), [Start(50.0, 0.0, 0.0)], Start(0.0, 0.0, math.pi), [], fence)
    set_moving(runs, 1, -4.0, 0.0)
    outcomes = [runs.advance(tick, [command(0.0, 0.0, 0.0), command(-4.0, 0.0)]) for tick in range(3)]
    assert outcomes == [FLYING, FLYING, ESCAPED]
    assert float(runs.record["end_s"][0]) == pytest.approx(0.25)


def test_encirclement_must_last() -> None:
    around = world(
        scenario("a2-encircle", evader__model="unicycle"), [Start(2.0, 0.0, 0.0), Start(0.0, 2.0, 0.0)], Start(0.0, 0.0, 0.0), []
    )
    outcomes = [around.advance(tick, [command(0.0, 0.0, 0.0)] * 3) for tick in range(11)]
    assert outcomes == [FLYING] * 10 + [CAPTURED]
    assert float(around.record["end_s"][0]) == pytest.approx(1.02)


@pytest.mark.parametrize("solid", [False, True])
def test_evader_passes_through_obstacles_unless_it_is_solid(solid: bool) -> None:
    runs = world(
        scenario(pursuers__count=1, evader__solid=solid), [Start(50.0, 0.0, 0.0)], Start(0.0, 0.0, 0.0), [disc(3.0, 0.0, 1.0)]
    )
    places = []
    for tick in range(40):
        runs.advance(tick, [command(0.0, 0.0, 0.0), command(3.0, 0.5)])
        places.append((float(runs.vehicles[1]["n"]), float(runs.vehicles[1]["e"])))
    nearest = min(math.dist(place, (3.0, 0.0)) for place in places)
    assert (nearest >= 1.25 - 1e-9) == solid
    assert places[-1][0] > 6.0


def test_smallest_clearance_is_the_one_of_the_whole_flight() -> None:
    """Against a fine sampling of the same flight past a field of discs, of which most are never near."""
    random = np.random.default_rng(5)
    discs = [disc(float(n), float(e), 0.5) for n, e in random.uniform(-40.0, 40.0, (60, 2)) if abs(e) > 1.2]
    flight = world(scenario(pursuers__count=1), [Start(-30.0, 0.0, 0.0)], Start(90.0, 90.0, 0.0), discs)
    for tick in range(100):
        assert flight.advance(tick, [command(6.0, 0.0), command(0.0, 0.0, 0.0)]) == FLYING
    north = np.arange(-30.0, float(flight.vehicles[0]["n"]), 0.001)
    rows = np.array(discs)
    gaps = np.hypot(north[:, None] - rows[:, 0], rows[:, 1]) - rows[:, 2] - 0.25
    assert float(flight.record["clearance"][0]) == pytest.approx(float(gaps.min()), abs=1e-5)
