from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clearance import clearance_m
from flightapp.core.types import Setpoint, TeamMember
from flightapp.safety.supervisor import Supervisor, make_supervisor
from tests.safety.closed_loop import (
    LIMITS,
    PERIOD_S,
    Body,
    context_of,
    discs_at,
    member_of,
    random_wishes,
    setpoint_of,
    target_at,
    towards,
)

ROOT = Path(__file__).parents[2]
MISSION = load_mission(ROOT / "missions" / "demo_two_pursuers.toml")
PROFILE = load_profile(ROOT / "profiles" / "sim.toml")
FENCE = Polygon(MISSION.flight_volume.vertices_m)
DISCS = discs_at(*[(c.north_m, c.east_m, c.radius_m) for c in MISSION.obstacles.cylinders])

anything = st.floats(allow_nan=True, allow_infinity=True)
number = st.floats(-30, 30)


def _supervisor(name: str = "p1", **safety: object) -> Supervisor:
    profile = PROFILE.model_copy(update={"safety": PROFILE.safety.model_copy(update=safety)})
    return make_supervisor(MISSION, profile, name)


@settings(max_examples=200, deadline=None)
@given(anything, anything, anything, anything, number, number, number, number, st.floats(0, 2), st.floats(0, 2))
def test_the_last_word_is_always_finite_and_within_the_limits(
    n: float,
    e: float,
    d: float,
    yaw: float,
    own_n: float,
    own_e: float,
    own_v: float,
    team_n: float,
    own_age: float,
    disc_age: float,
) -> None:
    context = context_of(
        Body("p1", (own_n, own_e), (own_v / 6, 0, 0)),
        team=(member_of(Body("p2", (team_n, 0.0), (1, 1, 0)), disc_age),),
        target=target_at((own_n + 1.0, own_e, -5), (-2, 0, 0)),
        discs=DISCS,
        own_age_s=own_age,
        obstacles_age_s=disc_age,
    )
    out = _supervisor().check(Setpoint(np.array([n, e, d]), yaw), context).setpoint
    assert np.isfinite(out.velocity_ned_m_s).all()
    assert math.isfinite(out.yaw_rad)
    assert np.hypot(*out.velocity_ned_m_s[:2]) <= LIMITS.speed_max_m_s + 1e-6
    assert abs(out.velocity_ned_m_s[2]) <= LIMITS.climb_rate_max_m_s + 1e-9


def test_a_planner_that_gives_nan_is_named_and_held() -> None:
    body = Body("p1", (10, 0))
    body.previous = setpoint_of(2.0, 0.0, 0.0, 0.4)
    supervised = _supervisor().check(setpoint_of(math.nan, 0.0), context_of(body))
    assert supervised.acting == (("finite", "planner gave a setpoint that is not finite"),)
    assert supervised.setpoint.yaw_rad == 0.4


def test_a_harmless_setpoint_passes_untouched() -> None:
    body = Body("p1", (5, 0), (2, 0, 0))
    body.previous = setpoint_of(2.0, 0.0)
    wish = setpoint_of(2.05, 0.0)
    supervised = _supervisor().check(wish, context_of(body, team=(member_of(Body("p2", (5, 10))),)))
    assert supervised.setpoint is wish
    assert supervised.acting == ()


def test_rate_limiting_does_not_reintroduce_what_a_spatial_guard_forbids() -> None:
    body = Body("p1", (64.4, 0), (1, 0, 0))
    body.previous = setpoint_of(5.0, 0.0)
    supervised = _supervisor().check(setpoint_of(5.0, 0.0), context_of(body))
    assert supervised.setpoint.velocity_ned_m_s[0] <= 1e-9
    assert "geofence" in dict(supervised.acting)


@pytest.mark.parametrize("seed", range(4))
def test_the_whole_of_it_keeps_fence_discs_evader_and_teammates(seed: int) -> None:
    """Three vehicles in the demo's volume with adversarial wishes: into each other, the obstacles and the fence."""
    rng = np.random.default_rng(seed)
    bodies = [Body("p1", (0, -8)), Body("p2", (0, 8))]
    supervisors = [_supervisor(body.name) for body in bodies]
    aims = [DISCS[rng.integers(len(DISCS)), :2], (80.0, 40.0), (5.0, 0.0), (-30.0, rng.uniform(-20, 20))]
    wishes = [[towards(aim, 8.0) for aim in rng.permutation(np.array(aims))] + [random_wishes(seed)] for _ in bodies]
    for step in range(round(15 / PERIOD_S)):
        t_s = step * PERIOD_S
        evader = np.array([25.0 + 3 * math.sin(t_s), 4 * math.cos(0.5 * t_s), -5.0])
        velocity = np.array([3 * math.cos(t_s), -2 * math.sin(0.5 * t_s), 0.0])
        sent = []
        for index, body in enumerate(bodies):
            other = bodies[1 - index]
            context = context_of(
                body,
                t_s,
                team=(TeamMember(other.name, other.state(t_s), "", None, 0.02),),
                target=target_at(evader, velocity, 0.02),
                discs=DISCS,
            )
            wish = wishes[index][int(t_s / 3) % 5](t_s, body)
            sent.append(supervisors[index].check(Setpoint(wish, 0.0), context).setpoint)
        for body, setpoint in zip(bodies, sent, strict=True):
            for point in body.fly(setpoint):
                assert FENCE.contains(Point(point[:2]))
                assert clearance_m(point[:2], DISCS, LIMITS.body_radius_m) > 0.0
        assert np.hypot(*(bodies[0].position - bodies[1].position)[:2]) >= PROFILE.safety.separation_min_m


def test_only_pursuers_keep_out_and_an_evader_yields_only_when_told() -> None:
    body = Body("e1", (30, 0))
    near = (member_of(Body("p1", (31.6, 0), (-1, 0, 0))),)
    wish = setpoint_of(0.1, 0.0)
    body.previous = wish
    assert _supervisor("e1").check(wish, context_of(body, team=near, target=target_at((30.5, 0, -5)))).acting == ()
    told = _supervisor("e1", evader_yields=True).check(wish, context_of(body, team=near))
    assert told.acting[0][0] == "separation"
    pursuer = Body("p1", (30, 0))
    pursuer.previous = wish
    context = context_of(pursuer, target=target_at((30.5, 0, -5)))
    assert "target-keep-out" in dict(_supervisor("p1").check(wish, context).acting)
    assert _supervisor("p1", target_keep_out_m=0.0).check(wish, context).acting == ()


def test_the_mission_s_own_speed_limit_counts() -> None:
    body = Body("e1", (30, 0), (5, 0, 0))
    body.previous = setpoint_of(5.0, 0.0)
    out = _supervisor("e1").check(setpoint_of(5.0, 0.0), context_of(body))
    assert out.setpoint.velocity_ned_m_s[0] == pytest.approx(2.5)
    assert dict(out.acting)["speed"] == "5.0 m/s wanted, limit 2.5 m/s"


def test_an_unknown_vehicle_is_an_error() -> None:
    with pytest.raises(KeyError):
        make_supervisor(MISSION, PROFILE, "nobody")


def test_the_same_inputs_give_the_same_words() -> None:
    def run() -> list[tuple[float, ...]]:
        supervisor, rng, words = _supervisor(), np.random.default_rng(3), []
        body = Body("p1", (10, 0))
        for _ in range(60):
            context = context_of(body, team=(member_of(Body("p2", rng.uniform(5, 15, 2), (1, 0, 0))),), discs=DISCS)
            out = supervisor.check(setpoint_of(*rng.uniform(-5, 5, 2)), context)
            body.fly(out.setpoint)
            words.append((*out.setpoint.velocity_ned_m_s.tolist(), out.setpoint.yaw_rad))
        return words

    assert run() == run()
