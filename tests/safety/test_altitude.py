from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.safety.guards.altitude import AltitudeGuard
from tests.safety.closed_loop import LIMITS, PARAMETERS, PERIOD_S, Body, context_of, setpoint_of

GUARD = AltitudeGuard(1.5, 15.0, PARAMETERS)
LAG_S, VERTICAL_M_S2 = 0.25, 2.0


def _heights(guard: AltitudeGuard | None, start_m: float, wishes: list[float]) -> np.ndarray:
    """Heights flown with a lagged vertical axis that accelerates at 2 m/s2 at most; wishes are climb rates, 0.5 s each."""
    body = Body("p1", (0.0, 0.0))
    body.position[2] = -start_m
    heights = []
    for climb in wishes:
        for _ in range(12):
            setpoint = setpoint_of(0.0, 0.0, -climb)
            if guard is not None:
                setpoint = guard.check(setpoint, context_of(body)).setpoint
            for _ in range(4):
                change = (setpoint.velocity_ned_m_s[2] - body.velocity[2]) / LAG_S
                body.velocity[2] += min(max(change, -VERTICAL_M_S2), VERTICAL_M_S2) * PERIOD_S / 4
                body.position[2] += body.velocity[2] * PERIOD_S / 4
                heights.append(-body.position[2])
    return np.array(heights)


@settings(max_examples=25, deadline=None)
@given(st.floats(1.8, 14.7), st.lists(st.sampled_from([-5.0, -2.0, 0.0, 2.0, 5.0]), min_size=10, max_size=20))
def test_the_band_is_kept(start_m: float, wishes: list[float]) -> None:
    heights = _heights(GUARD, start_m, wishes)
    assert heights.min() >= 1.5
    assert heights.max() <= 15.0


@pytest.mark.parametrize("climb", [-2.0, 2.0])
def test_without_the_guard_the_band_is_left_and_with_it_the_height_settles(climb: float) -> None:
    twin = _heights(None, 8.0, [climb] * 12)
    assert twin.min() < 1.5 or twin.max() > 15.0
    heights = _heights(GUARD, 8.0, [climb] * 24)
    edge = 14.8 if climb > 0 else 1.7
    assert heights[-1] == pytest.approx(edge, abs=0.03)
    assert np.abs(np.diff(heights)).sum() <= abs(heights[-1] - 8.0) + 0.1


@settings(max_examples=200, deadline=None)
@given(st.floats(-2, 25), st.floats(-5, 5), st.floats(-9, 9))
def test_never_faster_vertically_and_only_back_from_beyond_an_edge(height: float, climb: float, down: float) -> None:
    body = Body("p1", (0.0, 0.0), (1.0, 0.0, -climb))
    body.position[2] = -height
    verdict = GUARD.check(setpoint_of(1.0, 2.0, down, 0.7), context_of(body))
    out = verdict.setpoint.velocity_ned_m_s
    assert out[:2].tolist() == [1.0, 2.0]
    pushes = not 1.5 + 0.5 * PARAMETERS.height_margin_m <= height <= 15.0 - 0.5 * PARAMETERS.height_margin_m
    assert abs(out[2]) <= max(min(abs(down), LIMITS.climb_rate_max_m_s), PARAMETERS.push_back_m_s * pushes)
    if not pushes:
        assert out[2] * down >= 0.0
    if height >= 15.0:
        assert out[2] >= 0.0
    if height <= 1.5:
        assert out[2] <= 0.0
    assert (verdict.reason == "") == (out[2] == down)


@pytest.mark.parametrize(("start_m", "climb"), [(18.0, 2.0), (18.0, 0.0), (0.5, -2.0), (0.5, 0.0)])
def test_beyond_an_edge_it_is_brought_back_and_stays(start_m: float, climb: float) -> None:
    heights = _heights(GUARD, start_m, [climb] * 16)
    assert 1.5 < heights[-1] < 15.0
    turned = np.diff(np.sign(np.diff(heights[np.abs(heights - heights[-1]) > 0.02])))
    assert np.count_nonzero(turned) <= 1
    assert not 1.5 <= _heights(None, start_m, [climb] * 16)[-1] <= 15.0


def test_climb_and_sink_rate_each_have_their_limit() -> None:
    body = Body("p1", (0.0, 0.0))
    body.position[2] = -8.0
    context = dataclasses.replace(context_of(body), limits=dataclasses.replace(LIMITS, sink_rate_max_m_s=1.2))
    assert GUARD.check(setpoint_of(0.0, 0.0, 5.0), context).setpoint.velocity_ned_m_s[2] == 1.2
    assert GUARD.check(setpoint_of(0.0, 0.0, -5.0), context).setpoint.velocity_ned_m_s[2] == -LIMITS.climb_rate_max_m_s
