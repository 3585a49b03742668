from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.runtime.trap_watch import NEAR_M, STAYED_M, STUCK, WATCHED_S, TrapWatch

TARGET = np.array((50.0, 0.0, -5.0))
PERIOD_S = 0.2


def watched(places: list[tuple[float, float]], *, barred: bool = True, mode: str = "pursue") -> str:
    """What is said after a flight over `places`, one every PERIOD_S."""
    watch, said = TrapWatch(), ""
    for k, (north, east) in enumerate(places):
        said = watch.trapped(k * PERIOD_S, np.array((north, east, -5.0)), TARGET, mode, lambda: barred)
    return said


COUNT = round(WATCHED_S / PERIOD_S) + 2


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)), min_size=COUNT, max_size=COUNT))
def test_whoever_stays_before_something_that_bars_the_way_is_trapped_and_nobody_else(places: list[tuple[float, float]]) -> None:
    assert "the straight way to the evader is barred" in watched(places)
    assert watched(places, barred=False) == ""
    assert watched(places[:-3]) == "", "too early to tell"
    near = [(TARGET[0] + 0.5 * NEAR_M * north / 2.0, 0.5 * NEAR_M * east / 2.0) for north, east in places]
    assert watched(near) == "", "it is where it wants to be"


def test_who_moves_on_is_not_trapped_and_who_says_so_is_at_once() -> None:
    speed_m_s = 1.1 * STAYED_M / WATCHED_S
    assert watched([(speed_m_s * PERIOD_S * k, 0.0) for k in range(3 * COUNT)]) == ""
    assert watched([(8.0 * math.sin(0.3 * k), 8.0 * math.cos(0.3 * k)) for k in range(3 * COUNT)]) == ""
    assert watched([(0.0, 0.0)], mode=STUCK) == "the strategy says that it is stuck"
