"""What one row of the failsafe table does not show: things that end again, things that come together, things that follow."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from flightapp.config.profile import load_profile
from flightapp.core.types import Decision, Observation
from flightapp.runtime.outcome import Outcome
from flightapp.sim.autopilot_modes import Mode
from tests.sim.virtual.in_flight import BODY_M, SIM, Flight, clearance_m


def states(flight: Flight) -> list[str]:
    return [event["data"]["state"] for event in flight.events("failsafe")]


def assert_clear_of_the_tree(flight: Flight) -> None:
    assert min(map(clearance_m, flight.moments)) > 0.0


def commands_since(flight: Flight, t_s: float) -> list[str]:
    return [what for sent_s, what in flight.one.autopilot.commanded if sent_s > t_s]


def lose_camera(flight: Flight) -> None:
    assert flight.one.camera is not None
    flight.one.camera.fault = "off"


def find_camera(flight: Flight) -> None:
    assert flight.one.camera is not None
    flight.one.camera.fault = ""


def pilot_takes(flight: Flight) -> None:
    flight.one.station.core.pilot_takes(Mode.POSCTL)


def test_a_held_pursuer_gives_way_to_the_evader_and_goes_on_without_a_jump(tmp_path: Path) -> None:
    def towards_the_pursuer(t_s: float) -> tuple[float, float, float]:
        return 6.0 - 1.0 * max(0.0, t_s - 8.0), -1.5, -2.5

    flight = Flight(lambda flight: flight.command("hold"), 7.5, path=towards_the_pursuer)
    flight.then = ((5.0, lambda flight: flight.command("resume")),)
    flight.fly(tmp_path)
    assert flight.was_accepted()
    assert states(flight) == ["HOLD", "NORMAL"]
    assert_clear_of_the_tree(flight)
    resumed_s = flight.events("failsafe")[1]["t_s"]
    held = [moment for moment in flight.since(flight.broken_s) if moment.t_s < resumed_s]
    assert min(moment.evader_m for moment in held) < 1.5, "the evader really came"
    assert min(moment.evader_m for moment in held) > 2.0 * BODY_M
    assert flight.moments[-1].speed_m_s > 0.5
    assert_no_jump(flight, resumed_s - 0.2)


def assert_no_jump(flight: Flight, since_s: float) -> None:
    """No setpoint gains or turns by more than the vehicle may accelerate, twice that where a guard retreats; it may brake."""
    limit_m_s2 = 2.0 * load_profile(SIM).limits.acceleration_max_m_s2
    sent = [(t_s, setpoint.velocity_ned_m_s[:2]) for t_s, setpoint in flight.one.autopilot.sent if t_s > since_s]
    for (before_s, before), (t_s, now) in itertools.pairwise(sent):
        kept = min(1.0, max(0.0, float(now @ before) / max(1e-9, float(before @ before))))
        assert math.dist(kept * before, now) <= limit_m_s2 * (t_s - before_s) + 1e-6


def test_a_camera_that_comes_back_ends_the_hold(tmp_path: Path) -> None:
    flight = Flight(lose_camera, 6.0, then=((3.0, find_camera),)).fly(tmp_path)
    assert states(flight) == ["DEGRADED", "HOLD", "NORMAL"]
    assert_clear_of_the_tree(flight)
    assert flight.moments[-1].phase == "pursue"
    assert max(moment.speed_m_s for moment in flight.since(flight.broken_s + 4.2)) > 0.5


def test_with_the_pilot_in_control_no_failsafe_commands_anything(tmp_path: Path) -> None:
    def everything_at_once(flight: Flight) -> None:
        flight.fault("battery", "wrong", remaining=0.09)
        lose_camera(flight)
        pilot_takes(flight)

    flight = Flight(everything_at_once, 6.0).fly(tmp_path)
    assert flight.fault_was_felt()
    assert states(flight) == ["PILOT"]
    assert commands_since(flight, flight.broken_s) == []
    assert flight.moments[-1].mode is Mode.POSCTL


def test_the_operator_may_call_home_what_the_pilot_took_and_the_pilot_may_take_it_again(tmp_path: Path) -> None:
    flight = Flight(pilot_takes, 7.0)
    flight.then = (
        (2.0, lambda flight: flight.command("rtl")),
        (5.0, lambda flight: flight.one.station.core.pilot_takes(Mode.ALTCTL)),
    )
    flight.fly(tmp_path)
    assert flight.was_accepted()
    assert states(flight) == ["PILOT", "RETURN", "PILOT"]
    assert flight.broken_s + 2.0 < flight.mode_since_s(Mode.RTL, flight.broken_s) < flight.broken_s + 3.5
    assert flight.moments[-1].mode is Mode.ALTCTL
    assert commands_since(flight, flight.broken_s) == ["return"]


def test_after_a_black_out_px4_takes_up_the_setpoints_by_itself_and_they_stand_still(tmp_path: Path) -> None:
    flight = Flight(lambda flight: flight.fault("link", "off", duration_s=2.2), 5.0).fly(tmp_path)
    landing_s = flight.mode_since_s(Mode.LAND, flight.broken_s)
    resumed_s = flight.mode_since_s(Mode.OFFBOARD, landing_s)
    assert flight.fault_was_felt()
    assert landing_s < resumed_s < flight.broken_s + 2.4
    assert states(flight) == ["HOLD", "NORMAL"]
    assert commands_since(flight, flight.broken_s) == []
    at_once = [setpoint for t_s, setpoint in flight.one.autopilot.sent if abs(t_s - resumed_s) < 0.1]
    assert max(math.hypot(*setpoint.velocity_ned_m_s[:2]) for setpoint in at_once) < 0.6
    assert_clear_of_the_tree(flight)


def test_a_pilot_who_takes_over_during_a_black_out_keeps_the_vehicle(tmp_path: Path) -> None:
    flight = Flight(lambda flight: flight.fault("link", "off", duration_s=2.2), 5.0, then=((1.6, pilot_takes),)).fly(tmp_path)
    assert flight.fault_was_felt()
    assert states(flight)[0] == "HOLD"
    assert states(flight)[-1] == "PILOT"
    assert commands_since(flight, flight.broken_s) == []
    assert flight.moments[-1].mode is Mode.POSCTL
    assert flight.one.autopilot.sent[-1][0] <= flight.events("failsafe")[-1]["t_s"]


def test_an_own_clock_that_steps_back_ends_the_pursuit(tmp_path: Path) -> None:
    def step_back(flight: Flight) -> None:
        flight.one.clock.offset_s = -0.5

    flight = Flight(step_back, 12.0, until=lambda flight: flight.one.station.core.mode is Mode.RTL).fly(tmp_path)
    assert states(flight) == ["HOLD", "RETURN"]
    assert flight.events("failsafe")[0]["data"]["condition"] == "clocks_disagree"
    assert flight.moments[-1].mode is Mode.RTL
    assert_clear_of_the_tree(flight)


def test_a_strategy_that_raises_is_replaced_by_braking_and_the_way_home(tmp_path: Path) -> None:
    def raise_from_now_on(flight: Flight) -> None:
        def fail(_: Observation, decision: Decision) -> Decision:
            raise ZeroDivisionError("the strategy broke")

        flight.planner.fault = fail

    flight = Flight(raise_from_now_on, 90.0, until=lambda flight: not flight.one.station.core.armed).fly(tmp_path)
    assert flight.moment_at(flight.broken_s).speed_m_s > 1.5
    assert flight.one.outcome is Outcome.FAULT
    assert "the strategy broke" in str([event["text"] for event in flight.events("failsafe")])
    returning_s = flight.mode_since_s(Mode.RTL, flight.broken_s)
    last = [setpoint for t_s, setpoint in flight.one.autopilot.sent if t_s <= returning_s][-1]
    assert math.hypot(*last.velocity_ned_m_s[:2]) < 1.1, "it brakes before it hands over"
    assert [t_s for t_s, _ in flight.one.autopilot.sent if t_s > returning_s + 1.0] == []
    assert_clear_of_the_tree(flight)
    assert not flight.one.station.core.armed
    assert math.hypot(*flight.moments[-1].position_ned_m[:2]) < 1.0, "it is home"


def test_one_decision_that_is_not_finite_costs_a_hold_and_not_the_mission(tmp_path: Path) -> None:
    def give_nan_once(flight: Flight) -> None:
        def once(_: Observation, decision: Decision) -> Decision:
            flight.planner.fault = None
            return replace(decision, velocity_ned_m_s=np.full(3, np.nan), yaw_rad=math.nan)

        flight.planner.fault = once

    flight = Flight(give_nan_once, 3.0).fly(tmp_path)
    assert states(flight) == ["HOLD", "NORMAL"]
    assert flight.moments[-1].phase == "pursue"
    assert_clear_of_the_tree(flight)
