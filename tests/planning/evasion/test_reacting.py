"""The policies that flee: where to, along the edge of their area, around obstacles, and the same again."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.planning.registry import make_evader
from tests.planning.evasion.flight import LIMITS, chasing, disc, fly, observation

AREA = (-10.0, -10.0, 10.0, 10.0)


def wish(policy: str, pursuers: list[tuple[float, float]], **parameters: object) -> tuple[float, float]:
    rows = np.array([(*place, 0.0, 0.0) for place in pursuers]).reshape(-1, 4)
    evader = make_evader(policy, limits=LIMITS, parameters=parameters)
    n, e, _ = evader.step(observation(0.0, (0.0, 0.0), pursuers=rows)).velocity_ned_m_s
    return float(n), float(e)


def test_each_flees_in_its_own_way() -> None:
    ring = [(4.0, 0.0), (0.0, 5.0), (-5.0, 0.0)]
    assert wish("flee-nearest", ring) == pytest.approx((-4.0, 0.0), abs=0.05)
    n, e = wish("inverse-square", ring)
    assert n < 0.0, "from the nearer of the two that face each other"
    assert e < 0.0
    assert wish("gap-runner", ring) == pytest.approx((0.0, -4.0), abs=0.05), "half of the circle is open there"
    assert wish("goal-seeker", [(-20.0, 0.0)], goal_m=[0.0, 9.0]) == pytest.approx((0.0, 4.0), abs=0.05)


def test_a_wide_gap_between_far_pursuers_counts_less_than_a_narrower_one_that_is_near() -> None:
    _, e = wish("gap-runner", [(3.0, -2.0), (-3.0, -2.0), (0.0, 40.0)])
    assert e < 0.0


@pytest.mark.parametrize("policy", ["flee-nearest", "inverse-square", "gap-runner"])
def test_chased_within_an_area_it_stays_there_and_clear_of_obstacles(policy: str) -> None:
    evader = make_evader(policy, limits=LIMITS, parameters={"area_m": AREA, "edge_s": 0.8})
    flight = fly(evader, (5.0, 0.0), 15.0, pursuers=[(-5.0, 1.0)], pursuit=chasing(2.0), discs=[disc(6.0, 6.0, 1.0)])
    assert np.abs(np.array(flight.path)).max() < 11.0
    assert flight.clearance_m > 0.0
    assert len({tuple(np.round(place, 1)) for place in flight.path}) > 20, "it moves all the time"


def test_random_waypoints_follow_from_the_seed() -> None:
    def path(seed: int) -> list[tuple[float, float]]:
        return fly(make_evader("random-waypoints", limits=LIMITS, seed=seed), (0.0, 5.0), 12.0).path

    assert path(3) == path(3)
    assert path(3) != path(4)
    assert max(math.hypot(*place) for place in path(3)) < 15.0


@pytest.mark.parametrize("policy", ["flee-nearest", "voronoi-centroid", "random-waypoints"])
def test_an_area_without_extent_is_refused_by_name(policy: str) -> None:
    with pytest.raises(InputError, match=r"area_m .*least north, least east, greatest north, greatest east"):
        make_evader(policy, limits=LIMITS, parameters={"area_m": [0.0, 0.0, 0.0, 1.0]})
