"""The box: once the evader is encircled it only shrinks, never below what the team needs, and is the same for everybody."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.planning.encirclement.box import Box
from flightapp.planning.encirclement.parameters import EncirclementParameters
from tests.planning.encirclement.arena import CAPTURE

LATCH = EncirclementParameters.model_validate({"capture": CAPTURE, "evader_speed_assumed_m_s": 0.9})
PERIOD_S = 0.1
moment = st.tuples(st.floats(-5.0, 5.0), st.floats(0.2, 12.0), st.sampled_from([0.0, 0.0, 0.5, 2.0]))
"""The evader's distance to the hull, the team's extent, and how long ago the evader was seen."""


def flown(moments: list[tuple[float, float, float]]) -> tuple[Box, list[float]]:
    """The half sizes of one vehicle that saw `moments`."""
    box, sizes = Box(LATCH, 1.0, 0.16), []
    for tick, (hull_m, extent_m, age_s) in enumerate(moments):
        team = np.array(((extent_m, 0.0), (-extent_m, 0.3), (0.0, -0.1)))
        n, e = box.half_sizes_m(PERIOD_S * tick, PERIOD_S, team, (0.0, 0.0), age_s, hull_m, False)
        assert n == e
        sizes.append(n)
    return box, sizes


@settings(max_examples=60, deadline=None)
@given(st.lists(moment, min_size=1, max_size=80))
def test_it_follows_the_team_then_only_shrinks_and_everybody_has_the_same(moments: list[tuple[float, float, float]]) -> None:
    box, sizes = flown(moments)
    assert flown(moments)[1] == sizes
    first = next((k for k, (hull_m, _, _) in enumerate(moments) if hull_m < 0.0), len(moments))
    for k, (size, (_, extent_m, age_s)) in enumerate(zip(sizes, moments, strict=True)):
        least, _ = box.half_min_m(3, age_s)
        assert size >= least
        if k <= first:
            assert size == max(extent_m, least)
        elif size > least:
            assert size <= sizes[k - 1], "it does not open again"
    assert (box.since_s is None) == (first == len(moments))


@pytest.mark.parametrize("pursuers", [3, 7, 20])
def test_its_least_size_lets_the_nearest_capture_and_is_not_all_buffers(pursuers: int) -> None:
    least, crowded = Box(LATCH, 1.0, 0.16).half_min_m(pursuers, 0.0)
    assert least * 0.79 <= 1.0 + 1e-9
    assert crowded or least >= 1.5 * 0.16 * math.sqrt(pursuers + 1) - 1e-9
    assert Box(LATCH, 1.0, 0.16).half_min_m(pursuers, 2.0)[0] == pytest.approx(least + 1.8), "the evader may be anywhere by now"
