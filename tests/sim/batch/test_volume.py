"""The fast simulation in space: contact with what has a height, and whole episodes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.core.types import Decision, Observation
from flightapp.planning.boundary import NEVER
from flightapp.sim.batch.contact import first_within
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.families.layout import Layout, Start, disc_rows
from flightapp.sim.batch.records import COLLIDED, FLYING
from flightapp.sim.batch.setup import lay_out
from flightapp.sim.batch.volume.contact import cylinder_contact, first_within_reach
from flightapp.sim.batch.volume.world import VolumeWorld
from tests.sim.batch.stubs import AREA, FAR, command, scenario

near = st.floats(-3.0, 3.0)


@given(*[near] * 6, st.floats(0.2, 2.0), st.floats(-2.0, 0.0), st.floats(0.1, 2.0))
@settings(max_examples=80, deadline=None)
def test_contact_with_a_cylinder_is_where_samples_say(
    an: float, ae: float, ad: float, bn: float, be: float, bd: float, reach: float, over: float, high: float
) -> None:
    gap, touched = cylinder_contact(an, ae, ad, bn, be, bd, reach, over, over + high)
    share = np.linspace(0.0, 1.0, 2001)
    away, down = np.hypot(an + share * (bn - an), ae + share * (be - ae)) - reach, ad + share * (bd - ad)
    above = np.maximum(over - down, down - over - high)
    inside = (away < -1e-9) & (above < -1e-9)
    if inside.any():
        assert gap <= 0.0
        assert touched <= share[inside][0] + 1e-6
    if touched <= 1.0:
        k = round(2000 * touched)
        assert max(away[k], above[k]) < 0.01
    elif gap > 0.0:
        true = np.hypot(np.maximum(away, 0.0), np.maximum(above, 0.0)).min()
        assert gap <= true + 0.01 or (above < 0.0).any()


@given(*[near] * 4, st.floats(0.1, 2.0))
@settings(max_examples=60, deadline=None)
def test_at_one_height_the_reach_is_the_planar_one_to_the_bit(an: float, ae: float, bn: float, be: float, reach: float) -> None:
    assert first_within_reach(an, ae, 0.0, bn, be, 0.0, reach) == first_within(an, ae, bn, be, reach)
    unknown = cylinder_contact(an, ae, 0.0, bn, be, 0.0, reach, -math.inf, math.inf)[1]
    planar = first_within(an, ae, bn, be, reach)
    assert unknown == planar or (planar == NEVER and unknown == NEVER)


@pytest.mark.parametrize(("height_m", "outcome"), [(4.0, COLLIDED), (6.0, FLYING)])
def test_a_vehicle_passes_over_what_is_lower_and_hits_what_is_higher(height_m: float, outcome: int) -> None:
    of = scenario("a2-dense-volume", pursuers__count=1, volume__pursuer_height_m=height_m, volume__evader_height_m=20.0)
    discs = disc_rows([[5.0, 0.0, 1.0, 0.0, 0.0, -5.0, 0.0]])
    assert of.volume is not None
    world = VolumeWorld(of, of.volume, Layout(discs, FAR, (Start(0.0, 0.0, 0.0),), Start(50.0, 50.0, 0.0), AREA), 1, 2)
    assert world.obstacles(0)[0].discs[0].tolist() == discs[0].tolist(), "seen with its height"
    ended = FLYING
    for tick in range(25):
        if ended == FLYING:
            ended = world.advance(tick, [command(5.0, 0.0), command(0.0, 0.0)])
    assert ended == outcome
    if outcome == FLYING:
        assert world.record[0]["clearance"] == pytest.approx(height_m - 5.0 - of.pursuers.body_radius_m, abs=1e-9)


def test_climb_is_limited_in_rate_and_acceleration() -> None:
    of = scenario("a2-dense-volume", pursuers__count=1)
    assert of.volume is not None
    world = VolumeWorld(of, of.volume, Layout(disc_rows([]), FAR, (Start(0.0, 0.0, 0.0),), Start(50.0, 50.0, 0.0), AREA), 1, 2)
    up = replace(command(0.0, 0.0), velocity_ned_m_s=np.array((0.0, 0.0, -9.0)))
    rates = []
    for tick in range(20):
        world.advance(tick, [up, command(0.0, 0.0)])
        rates.append(-float(world.states(0.0)[0].velocity_ned_m_s[2]))
    assert rates[0] == pytest.approx(0.3)
    assert max(np.diff(rates)) <= 0.3 + 1e-9
    assert 1.9 < rates[-1] <= 2.0


class Heights:
    """Watches the heights of an episode."""

    def __init__(self) -> None:
        self.rows: list[list[float]] = []

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        self.rows.append([-float(state.position_ned_m[2]) for state in truth.states])

    def end(self, truth: Truth) -> None:
        """Nothing to note."""


def test_an_evader_that_climbs_and_dives_is_captured_in_space_and_not_by_the_planar_mode() -> None:
    of, watched, flat = scenario("a2-dense-volume"), Heights(), Heights()
    seed = 10003
    first, again = fly(of, "ac2f", seed, watcher=watched), fly(of, "ac2f", seed)
    assert first.outcome == "captured"
    assert first.min_clearance_m > 0.0
    assert (first.capture_time_s, first.travel_m) == (again.capture_time_s, again.travel_m)
    heights = np.array(watched.rows)
    assert 1.9 < heights.min() < heights.max() < 13.0
    assert np.ptp(heights[:, -1]) > 5.0
    assert np.abs(heights[-1, :2] - heights[-1, 2]).min() < 0.6
    planar = fly(of, "ac2f", seed, {"volume": {"space": "plane"}}, flat)
    assert planar.outcome == "escaped"
    assert np.array(flat.rows)[:, :2].tolist() == [[5.0, 5.0]] * len(flat.rows)


def test_heights_of_obstacles_are_drawn_beside_the_layout_and_leave_it_as_it_is() -> None:
    planar, spatial = lay_out(scenario("a2-dense"), 3), lay_out(scenario("a2-dense-volume"), 3)
    assert planar.discs[:, :5].tolist() == spatial.discs[:, :5].tolist()
    assert planar.pursuers == spatial.pursuers
    assert ((spatial.discs[:, 5] <= -3.0) & (spatial.discs[:, 5] >= -12.0)).all()
    assert (spatial.discs[:, 6] == 0.0).all()
    assert spatial.discs.tolist() == lay_out(scenario("a2-dense-volume"), 3).discs.tolist()


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("capture__mode", "all", "volume: capture.mode = 'all' is not simulated in space; must be 'first'"),
        ("sensing__position_noise_m", 0.1, "volume: sensing is not simulated in space; must be without noise"),
        ("volume__disc_height_m", [9.0, 3.0], "must be least and greatest height"),
    ],
)
def test_what_is_not_simulated_in_space_is_refused(field: str, value: object, said: str) -> None:
    with pytest.raises(InputError, match=said.replace("[", r"\[")):
        scenario("a2-dense-volume", **{field: value})


def test_a_vehicle_that_sinks_more_slowly_than_it_climbs_does_so_and_its_planner_knows() -> None:
    of = scenario("a2-dense-volume", pursuers__count=1, pursuers__climb_rate_max_m_s=3.0, pursuers__sink_rate_max_m_s=1.0)
    assert (of.pursuers.limits().climb_rate_max_m_s, of.pursuers.limits().sink_rate_max_m_s) == (3.0, 1.0)
    assert of.volume is not None
    for wanted, flown in ((-9.0, -3.0), (9.0, 1.0)):
        world = VolumeWorld(
            of, of.volume, Layout(disc_rows([]), FAR, (Start(0.0, 0.0, 0.0),), Start(50.0, 50.0, 0.0), AREA), 1, 2
        )
        decision = replace(command(0.0, 0.0), velocity_ned_m_s=np.array((0.0, 0.0, wanted)))
        for tick in range(40):
            world.advance(tick, [decision, command(0.0, 0.0)])
        assert float(world.states(0.0)[0].velocity_ned_m_s[2]) == pytest.approx(flown, abs=0.02)
