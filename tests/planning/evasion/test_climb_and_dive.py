"""The evader that climbs and dives."""

from __future__ import annotations

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import Boundary, Observation, ObstacleSet, TeamMember, VehicleState
from flightapp.planning.registry import make_evader
from tests.planning.evasion.flight import LIMITS

LINE = Boundary(np.array([[0.0, -30.0], [0.0, 30.0]]), False)
NOTHING = np.zeros((0, 7))


def heights(pursuer_from_s: float | None = None) -> list[float]:
    """Of 25 s of flight; a pursuer is 3 m away from a time on."""
    evader = make_evader("climb-and-dive", limits=LIMITS, parameters={"height_low_m": 3.0, "height_high_m": 9.0})
    place, velocity, told = np.array((90.0, 0.0, -5.0)), np.zeros(3), []
    for step in range(250):
        t_s = 0.1 * step
        near = pursuer_from_s is not None and t_s >= pursuer_from_s
        state = VehicleState(t_s, place + np.array((3.0, 0.0, 0.0)), np.zeros(3), 0.0)
        team = (TeamMember("p1", state, "coarse", None, 0.0),) if near else ()
        own = VehicleState(t_s, place, velocity, 0.0)
        decision = evader.step(Observation(t_s, 0.1, own, team, None, ObstacleSet(t_s, NOTHING, np.zeros((0, 2))), LINE))
        assert decision.flies_height
        assert abs(decision.velocity_ned_m_s[2]) <= 1.5
        velocity = decision.velocity_ned_m_s
        place = place + 0.1 * velocity
        told.append(-float(place[2]))
    assert place[0] < 80.0, "towards the boundary meanwhile"
    return told


def test_it_goes_up_and_down_within_its_band() -> None:
    flown = heights()
    assert 2.7 < min(flown) < 3.4
    assert 8.6 < max(flown) < 9.3


def test_a_pursuer_that_comes_near_makes_it_turn() -> None:
    alone, chased = heights(), heights(1.0)
    assert alone[:9] == chased[:9]
    assert chased[25] < alone[25] - 1.0, "dives instead of climbing on"


def test_its_heights_must_be_a_band() -> None:
    with pytest.raises(InputError, match=r"height_low_m = 9.0 must be less than height_high_m = 3.0"):
        make_evader("climb-and-dive", limits=LIMITS, parameters={"height_low_m": 9.0, "height_high_m": 3.0})
