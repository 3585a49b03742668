"""The pose that belongs to a depth frame."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
from flightapp.core.types import VehicleState
from flightapp.vehicle.pose_history import EXTRAPOLATION_MAX_S, PoseHistory

YAW_RATE = 3.0


def history_of_a_turn(offset_s: float = 0.007) -> PoseHistory:
    """50 Hz for 1 s: 4 m/s north, turning at 3 rad/s; attitudes lie `offset_s` beside the positions."""
    history = PoseHistory()
    for number in range(51):
        t_s = 0.02 * number
        history.append_state(VehicleState(t_s, np.array([4.0 * t_s, 0.0, -5.0]), np.array([4.0, 0.0, 0.0]), 0.0))
        history.append_attitude(t_s + offset_s, 0.1, -0.05, wrap_pi(3.0 + YAW_RATE * (t_s + offset_s)))
    return history


@given(st.floats(0.03, 1.0))
def test_position_and_attitude_belong_to_the_asked_time(t_s: float) -> None:
    motion = history_of_a_turn().at(t_s)
    assert motion is not None
    assert motion.state.position_ned_m[0] == pytest.approx(4.0 * t_s, abs=1e-6)
    assert abs(wrap_pi(motion.state.yaw_rad - (3.0 + YAW_RATE * t_s))) < 1e-6
    assert -math.pi < motion.state.yaw_rad <= math.pi


def test_a_frame_newer_than_the_telemetry_is_extrapolated_a_little_and_no_more() -> None:
    history = history_of_a_turn()
    soon = history.at(1.05)
    assert soon is not None
    assert soon.state.position_ned_m[0] == pytest.approx(4.2)
    assert abs(wrap_pi(soon.state.yaw_rad - (3.0 + YAW_RATE * 1.05))) < 1e-6
    assert history.at(1.0 + EXTRAPOLATION_MAX_S + 0.01) is None


def test_times_before_the_history_are_unknown() -> None:
    assert PoseHistory().at(0.0) is None
    assert history_of_a_turn().at(-0.5) is None


def test_nothing_is_known_between_messages_that_are_far_apart() -> None:
    history = PoseHistory()
    for t_s in (0.0, 0.02, 1.0):
        history.append_state(VehicleState(t_s, np.zeros(3), np.zeros(3), 0.0))
        history.append_attitude(t_s, 0.0, 0.0, 3.0 * t_s)
    assert history.at(0.5) is None
    assert history.at(0.01) is not None
    held = history.at(1.02)
    assert held is not None
    assert held.state.yaw_rad == pytest.approx(3.0), "no rate was measured lately"


@given(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=80))
def test_known_times_are_in_order_whatever_the_clock_of_the_autopilot_does(steps_s: list[float]) -> None:
    history = PoseHistory(length=20)
    t_s = 100.0
    for step_s in steps_s:
        t_s += step_s
        history.append_state(VehicleState(t_s, np.zeros(3), np.zeros(3), 0.0))
        history.append_attitude(t_s, 0.0, 0.0, 0.0)
        assert history.newest_s == t_s
        assert history.oldest_s <= t_s
        assert history.at(t_s) is not None
    assert history.at(history.oldest_s - 0.01) is None
