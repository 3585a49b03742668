"""Random situations through every strategy and the supervisor: no exception, finite answers, within the limits.

FLIGHTAPP_FUZZ_EXAMPLES=20000 looks longer.
"""

from __future__ import annotations

import math
import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.types import Decision, Limits, Observation, Setpoint
from flightapp.planning.api import Planner
from flightapp.planning.registry import evader_names, make_evader, make_planner, planner_names
from flightapp.runtime.composition import limits_of
from flightapp.safety.api import SafetyContext
from flightapp.safety.supervisor import make_supervisor
from tests.replay.situations import Shape, shapes, situation

ROOT = Path(__file__).parents[2]
MISSION = load_mission(ROOT / "missions/demo_two_pursuers.toml")
PROFILE = load_profile(ROOT / "profiles/sim.toml")
VEHICLE = MISSION.vehicle("p1")
LIMITS = limits_of(VEHICLE, PROFILE)
EXAMPLES = int(os.environ.get("FLIGHTAPP_FUZZ_EXAMPLES", "25"))
ROUNDING = 1e-6
MOVES_AWAY = {"geofence", "separation", "target-keep-out", "obstacle-stop", "altitude", "contingency"}
"""Guards that may ask for more than the vehicle's acceleration: they brake and retreat."""


@pytest.fixture(scope="module")
def track(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fuzz") / "track.csv"
    rows = [f"{0.1 * i},{2.0 * math.cos(0.1 * i)},{0.4 * i},-1,0,0,0,1" for i in range(100)]
    path.write_text("\n".join(["timestamp,tx,ty,tz,qx,qy,qz,qw", *rows]) + "\n")
    return path


@cache
def planner(name: str, track: Path | None = None) -> Planner:
    """Kept over all examples, as in flight: what one bad situation leaves behind must not hurt the next one."""
    parameters = {"recorded": {"file": str(track)}, "waypoints": {"waypoints": [10.0, 0.0, 0.0, 10.0]}}
    make = make_evader if name in evader_names() else make_planner
    return make(name, limits=LIMITS, parameters=parameters.get(name), seed=1)


def assert_usable(decision: Decision, limits: Limits) -> None:
    assert decision.velocity_ned_m_s.shape == (3,)
    assert np.isfinite(decision.velocity_ned_m_s).all()
    assert math.isfinite(decision.yaw_rad)
    assert -math.pi - ROUNDING <= decision.yaw_rad <= math.pi + ROUNDING
    assert math.hypot(*decision.velocity_ned_m_s[:2]) <= limits.speed_max_m_s + ROUNDING
    assert abs(decision.velocity_ned_m_s[2]) <= limits.climb_rate_max_m_s + ROUNDING
    assert decision.goal_ned_m is None or np.isfinite(decision.goal_ned_m).all()
    assert decision.mode


@pytest.mark.parametrize("name", [*planner_names(), *evader_names()])
@settings(max_examples=EXAMPLES, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(shape=shapes)
def test_every_strategy_decides_something_that_can_be_flown(name: str, shape: Shape, track: Path) -> None:
    decides = planner(name, track)
    if shape.seed % 3 == 0:
        decides.reset()
    for seen in situation(shape):
        assert_usable(decides.step(seen), LIMITS)


@settings(max_examples=2 * EXAMPLES, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(shape=shapes)
def test_what_the_supervisor_sends_is_within_the_limits(shape: Shape) -> None:
    supervisor = make_supervisor(MISSION, PROFILE, "p1")
    decides = planner("ac2f")
    previous: Setpoint | None = None
    for seen in situation(shape):
        decision = decides.step(seen)
        wish = Setpoint(decision.velocity_ned_m_s, decision.yaw_rad)
        supervised = supervisor.check(wish, context(seen, previous))
        sent = supervised.setpoint.velocity_ned_m_s
        assert np.isfinite(sent).all()
        assert math.isfinite(supervised.setpoint.yaw_rad)
        assert not any(name == "supervisor" for name, _ in supervised.acting), supervised.acting
        assert math.hypot(*sent[:2]) <= LIMITS.speed_max_m_s + ROUNDING
        assert abs(sent[2]) <= LIMITS.climb_rate_max_m_s + ROUNDING
        acting = {name for name, _ in supervised.acting}
        if previous is not None and 0.01 <= seen.dt_s <= 0.2 and not acting & MOVES_AWAY:
            gained = math.hypot(*sent[:2]) - math.hypot(*previous.velocity_ned_m_s[:2])
            assert gained <= LIMITS.acceleration_max_m_s2 * seen.dt_s + ROUNDING
        previous = supervised.setpoint


def context(seen: Observation, previous: Setpoint | None) -> SafetyContext:
    return SafetyContext(
        t_s=seen.t_s,
        dt_s=seen.dt_s,
        name="p1",
        own=seen.own,
        own_age_s=0.02,
        team=seen.team,
        target=seen.target,
        obstacles=seen.obstacles,
        obstacles_age_s=seen.t_s - seen.obstacles.t_s,
        previous=previous,
        limits=LIMITS,
        team_link_age_s=min((member.age_s for member in seen.team), default=None),
        battery_fraction=0.7,
    )
