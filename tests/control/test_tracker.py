"""`aadrc-smc` over a velocity loop: what it adds, what the guards leave of it, and that it is off unless asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.control.tracker import VelocityTracker, make_tracker
from flightapp.core.types import Setpoint, VehicleState
from flightapp.runtime.composition import build_tracker, feeds_forward
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.sim.mock_autopilot import frame_limits, with_velocity_loop
from flightapp.sim.multirotor import Command, Multirotor, Wind
from flightapp.vehicle.velocity_gains import VelocityGains

MISSIONS = Path(__file__).resolve().parents[2] / "missions"
PROFILE = load_profile(MISSIONS.parent / "profiles" / "sim.toml")


def error_in_wind(tracker: VelocityTracker | None, *, guarded: bool = False, gain_1_s: float = 1.8) -> float:
    """Mean planar velocity error, m/s, of a weaving flight in 8 m/s of wind under PX4's own loop."""
    limits = replace(with_velocity_loop(frame_limits(PROFILE.limits), "px4"), velocity_gain_1_s=gain_1_s)
    vehicle = Multirotor(limits, position_ned_m=(0.0, 0.0, -5.0), wind=Wind(5.7, 5.7, 1.5), ground_down_m=0.0, seed=3)
    vehicle.motors.running, vehicle.on_ground = True, False
    errors = []
    for tick in range(500):
        own = VehicleState(0.02 * tick, np.array(vehicle.position_ned_m), np.array(vehicle.velocity_ned_m_s), 0.0)
        decided = np.array((3.0 * np.cos(0.3 * own.t_s), 3.0 * np.sin(0.3 * own.t_s), 0.0))
        sent = Setpoint(decided, 0.0)
        if tracker is not None:
            tracker.watch(own, 0.02)
            sent = tracker.wish(sent)
            sent = with_velocity(sent, *decided.tolist()) if guarded else sent
            tracker.note(sent)
        forward = sent.fed_forward_ned_m_s2
        pushes = (0.0, 0.0, 0.0) if forward is None else tuple(forward.tolist())
        for _ in range(4):
            vehicle.step(0.005, Command(tuple(sent.velocity_ned_m_s.tolist()), acceleration_ned_m_s2=pushes))
        errors.append(float(np.linalg.norm(np.array(vehicle.velocity_ned_m_s)[:2] - decided[:2])))
    return float(np.mean(errors[100:]))


def test_it_takes_out_most_of_wind_and_lag_and_still_much_where_guards_drop_what_belongs_to_the_velocity() -> None:
    alone = error_in_wind(None)
    assert error_in_wind(make_tracker(PROFILE)) < 0.5 * alone
    assert error_in_wind(make_tracker(PROFILE), guarded=True) < 0.75 * alone


def test_it_follows_better_where_it_knows_the_gain_of_the_loop_below() -> None:
    assumed, told = make_tracker(PROFILE), make_tracker(PROFILE)
    told.fly_over(VelocityGains(0.5, 4.0))
    assert error_in_wind(told, gain_1_s=0.5) < 0.95 * error_in_wind(assumed, gain_1_s=0.5)


def test_a_guard_that_changes_the_velocity_leaves_the_compensation_of_the_wind() -> None:
    wish = Setpoint(np.ones(3), 0.0, np.array((1.0, 0.0, 0.0)), np.array((0.0, 2.0, 0.0)))
    assert wish.fed_forward_ned_m_s2 == pytest.approx((1.0, 2.0, 0.0))
    assert with_velocity(wish, 0.0, 0.0, 0.0).fed_forward_ned_m_s2 == pytest.approx((0.0, 2.0, 0.0))


def test_it_flies_pursuers_where_mission_or_profile_ask_for_it_and_nobody_else() -> None:
    plain, windy = load_mission(MISSIONS / "demo_two_pursuers.toml"), load_mission(MISSIONS / "demo_wind.toml")
    assert build_tracker(plain, plain.vehicle("p1"), PROFILE) is None
    assert not feeds_forward(plain, PROFILE)
    assert build_tracker(windy, windy.vehicle("p1"), PROFILE) is not None
    assert build_tracker(windy, windy.vehicle("e1"), PROFILE) is None
    assert feeds_forward(windy, PROFILE)


def test_without_an_own_state_the_decision_goes_through_unchanged() -> None:
    tracker, decided = make_tracker(PROFILE), Setpoint(np.ones(3), 0.5)
    assert tracker.wish(decided) is decided
    tracker.watch(VehicleState(0.0, np.zeros(3), np.zeros(3), 0.0), 0.02)
    assert tracker.wish(decided).fed_forward_ned_m_s2 is not None
    for _ in range(30):
        tracker.watch(VehicleState(0.0, np.full(3, np.nan), np.full(3, np.nan), 0.0), 0.02)
    assert tracker.wish(decided) is decided
