from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.safety.api import Action, Demand
from flightapp.safety.guards.battery import BatteryGuard
from flightapp.safety.parameters import SafetyParameters
from tests.safety.closed_loop import Body, context_of

PARAMETERS = SafetyParameters(endurance_s=600.0, return_speed_m_s=4.0, landing_speed_m_s=0.7)
GROUND_M, RETURN_M, HEIGHT_M = 0.0, 10.0, 5.0
CLIMB_M_S, PERIOD_S = 2.0, 0.2


class Flight:
    """Away from home at 2 m/s until RETURN is obeyed (or never), then home and down; the battery drains all the time.

    The gauge shows whole per cents, with dips of 15 % for one second now and then.
    """

    def __init__(self, drain_1_s: float, *, obeys: bool, seed: int = 0, wind_loss_m_s: float = 0.0) -> None:
        guard = BatteryGuard((0.0, 0.0), GROUND_M, RETURN_M, PARAMETERS)
        random = np.random.default_rng(seed)
        self.demands: list[Demand] = []
        body, self.left, t_s, homewards, dip_until_s = Body("p1", (0.0, 0.0)), 1.0, 0.0, False, -1.0
        while self.left > 0.0 and not (homewards and body.position[2] >= 0.0):
            t_s += PERIOD_S
            self.left -= drain_1_s * PERIOD_S
            dip_until_s = t_s + 1.0 if random.random() < 0.002 else dip_until_s
            shown = max(0.0, math.floor(100 * self.left) / 100 - (0.15 if t_s < dip_until_s else 0.0))
            demand = guard.demand(dataclasses.replace(context_of(body, t_s, dt_s=PERIOD_S), battery_fraction=shown))
            if demand is not None and (not self.demands or demand != self.demands[-1]):
                self.demands.append(demand)
            homewards |= obeys and demand is not None
            self._move(body, homewards, wind_loss_m_s)
        self.is_down = body.position[2] >= 0.0

    def _move(self, body: Body, homewards: bool, wind_loss_m_s: float) -> None:
        north, _, down = body.position
        if not homewards:
            body.position[0] += 2.0 * PERIOD_S
        elif north > 0.0 and down > -RETURN_M:
            body.position[2] -= CLIMB_M_S * PERIOD_S
        elif north > 0.0:
            body.position[0] -= (PARAMETERS.return_speed_m_s - wind_loss_m_s) * PERIOD_S
        else:
            body.position[2] += PARAMETERS.landing_speed_m_s * PERIOD_S


@settings(max_examples=20, deadline=None)
@given(st.floats(1 / 600, 3 / 600), st.integers(0, 99))
def test_whoever_returns_when_asked_is_home_with_the_reserve_and_its_twin_falls(drain_1_s: float, seed: int) -> None:
    flight = Flight(drain_1_s, obeys=True, seed=seed)
    assert flight.is_down
    assert flight.left > PARAMETERS.battery_reserve_fraction - 0.05
    assert [demand.action for demand in flight.demands] == [Action.RETURN]
    assert not Flight(drain_1_s, obeys=False, seed=seed).is_down


def test_who_does_not_return_is_asked_to_land_and_nothing_flaps() -> None:
    flight = Flight(1 / 600, obeys=False)
    assert [demand.action for demand in flight.demands] == [Action.RETURN, Action.LAND]
    assert "% left, the way home takes" in flight.demands[0].reason


def _asked(guard: BatteryGuard, left: float | None, seconds: float, began_s: float = 0.0, north: float = 0.0) -> Demand | None:
    body, demand = Body("p1", (north, 0.0)), None
    for step in range(round(seconds / PERIOD_S)):
        context = context_of(body, began_s + step * PERIOD_S, dt_s=PERIOD_S)
        demand = guard.demand(dataclasses.replace(context, battery_fraction=left))
    return demand


def _guard() -> BatteryGuard:
    return BatteryGuard((0.0, 0.0), GROUND_M, RETURN_M, PARAMETERS)


@pytest.mark.parametrize(
    ("left", "north", "action"),
    [(0.9, 0.0, None), (0.24, 0.0, None), (0.21, 0.0, Action.RETURN), (0.24, 500.0, Action.RETURN), (0.15, 500.0, Action.LAND)],
)
def test_what_is_asked_depends_on_the_way_home(left: float, north: float, action: Action | None) -> None:
    demand = _asked(_guard(), left, 4.0, north=north)
    assert (None if demand is None else demand.action) == action


def test_the_way_home_is_flight_climb_and_descent() -> None:
    body = Body("p1", (30.0, 40.0))
    assert _guard().way_home_s(context_of(body)) == pytest.approx(50.0 / 4.0 + 5.0 / 2.0 + 10.0 / 0.7)
    body.position[2] = -25.0
    assert _guard().way_home_s(context_of(body)) == pytest.approx(50.0 / 4.0 + 25.0 / 0.7)


def test_a_short_dip_and_an_unknown_battery_ask_for_nothing_and_a_demand_stays() -> None:
    guard = _guard()
    assert _asked(guard, 0.05, 2.5) is None
    assert _asked(guard, 0.9, 5.0, 2.5) is None
    assert _asked(guard, None, 60.0, 10.0) is None
    asked = _asked(guard, 0.21, 4.0, 70.0)
    assert asked.action == Action.RETURN
    assert _asked(guard, 1.0, 100.0, 80.0) == asked
    assert _asked(guard, None, 10.0, 200.0) == asked
