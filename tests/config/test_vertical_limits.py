"""Climb and sink rate: two limits, and one where the second is not given."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flightapp.config.profile import VehicleLimits, load_profile
from flightapp.core.types import Limits, VehicleState
from flightapp.runtime.hover import Hover
from flightapp.sim.mock_autopilot import frame_limits

PROFILES = Path(__file__).parents[2] / "profiles"
GIVEN = {
    "speed_max_m_s": 5.0,
    "acceleration_max_m_s2": 5.0,
    "jerk_max_m_s3": 40.0,
    "yaw_rate_max_rad_s": 3.0,
    "yaw_acceleration_max_rad_s2": 12.0,
    "climb_rate_max_m_s": 3.0,
    "body_radius_m": 0.35,
    "safety_margin_m": 0.45,
}


def test_a_profile_without_a_sink_rate_sinks_as_it_climbs() -> None:
    assert VehicleLimits(**GIVEN).as_limits().sink_rate_max_m_s == 3.0  # type: ignore[arg-type]
    assert Limits(5.0, 5.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45).sink_rate_max_m_s == 2.0
    assert load_profile(PROFILES / "sim.toml").limits.sink_rate_max_m_s == 2.0


def test_a_sink_rate_of_its_own_reaches_planner_and_airframe() -> None:
    limits = VehicleLimits(**GIVEN, sink_rate_max_m_s=1.5)  # type: ignore[arg-type]
    assert (limits.as_limits().climb_rate_max_m_s, limits.as_limits().sink_rate_max_m_s) == (3.0, 1.5)
    frame = frame_limits(limits)
    assert frame.climb_rate_max_m_s == pytest.approx(2.0 * frame.descent_rate_max_m_s)
    real = load_profile(PROFILES / "nuc-pixhawk6c-d435.toml").limits
    assert real.sink_rate_max_m_s < real.climb_rate_max_m_s


def test_the_height_loop_asks_for_no_more_than_either_limit() -> None:
    hover = Hover(10.0, 3.0, 1.0, sink_rate_max_m_s=1.2)
    asked = [
        hover.down_velocity_m_s(VehicleState(0.0, np.array((0.0, 0.0, -height)), np.zeros(3), 0.0)) for height in (2.0, 18.0)
    ]
    assert asked == [-3.0, 1.2]
