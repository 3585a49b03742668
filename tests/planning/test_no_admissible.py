"""Where no arc of the dynamic window is admissible: evade or brake while moving, turn to the free gap while standing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.types import Decision
from flightapp.planning.registry import make_planner
from tests.planning.closed_loop import disc, limits
from tests.planning.test_planner import observation

COMING = [disc(2.2, 0.35, 0.5)]
"""An obstacle ahead, a little to the right, that leaves no room to brake for a vehicle at 4 m/s."""
NEAR_EVADER = (2.4, 0.0)
FORMS: dict[str, dict[str, object]] = {
    "ac2f": {"stages": "fine", "terminal_adaptation": False},
    "ac2f-literal": {"stages": "fine", "terminal_adaptation": False, "admissibility": True},
    "dwa-fixed": {},
}
"""Each with the same horizon, in the fine stage from the first step."""


def decision_of(name: str, velocity: tuple[float, float], discs: list[list[float]]) -> Decision:
    """The first decision of a vehicle at the origin that looks north, in the fine stage."""
    planner = make_planner(name, limits=limits(), parameters={"vehicle_radius_max_m": 0.0, **FORMS[name]})
    decision = planner.step(observation(0.0, velocity=velocity, discs=discs, target=NEAR_EVADER))
    assert decision.diagnostics["no_admissible"]
    return decision


def ring(gap_rad: float) -> list[list[float]]:
    """Discs all around the origin but for a gap at the bearing `gap_rad`, that close in on it too fast to do anything."""
    places = [(math.cos(bearing), math.sin(bearing)) for bearing in gap_rad + np.linspace(1.2, 2.0 * math.pi - 1.2, 24)]
    return [[2.2 * n, 2.2 * e, 0.35, -4.0 * n, -4.0 * e, -math.inf, math.inf] for n, e in places]


@pytest.mark.parametrize("east", [-0.35, 0.35])
def test_moving_it_evades_to_the_free_side(east: float) -> None:
    decision = decision_of("ac2f", (4.0, 0.0), [disc(2.2, east, 0.5)])
    assert decision.velocity_ned_m_s[1] * east < -0.01
    assert decision.velocity_ned_m_s[0] < 4.0


@pytest.mark.parametrize("name", ["ac2f-literal", "dwa-fixed"])
def test_moving_the_literal_forms_brake_along_their_arc(name: str) -> None:
    decision = decision_of(name, (4.0, 0.0), COMING)
    assert math.hypot(*decision.velocity_ned_m_s[:2]) < 4.0
    assert decision.velocity_ned_m_s[1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("gap_rad", [-2.0, 0.5, 3.0])
def test_standing_it_turns_to_the_free_gap(name: str, gap_rad: float) -> None:
    decision = decision_of(name, (0.0, 0.0), ring(gap_rad))
    assert (decision.velocity_ned_m_s == 0.0).all()
    assert decision.yaw_rad == pytest.approx(gap_rad, abs=0.05)
