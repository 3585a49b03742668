"""A vehicle process that ends before OFFBOARD: nothing of PX4's own ends a climb, so the deadman has the vehicle landed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from flightapp.sim.autopilot_modes import Mode
from flightapp.vehicle.last_resort import Advice, advice
from tests.sim.virtual.in_flight import Flight

ARMED = 0b1000_0000
IN_THE_CLIMB_S = 3.5
LANDED_S = 15.0
SEEN_TO_RETURN = 40
"""Moments of 5 ms: the deadman has been told since."""
LINK_LOST_S = 14.0
"""Longer than the app waits for a lost link."""


def kill(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.one.kill()


def hang(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.one.hang()


def kill_under_a_pilot(flight: Flight) -> None:
    flight.one.station.core.pilot_takes(Mode.POSCTL)
    kill(flight)


def return_early(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.command("rtl")


def is_down_after_a_death_before_it_returns(flight: Flight) -> bool:
    latest = flight.moments[-SEEN_TO_RETURN:]
    if all(moment.phase == "return" and moment.mode in (Mode.TAKEOFF, Mode.HOLD) for moment in latest):
        flight.one.kill()
    return is_down(flight)


def lose_the_link(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.fault("link", "off", duration_s=LINK_LOST_S)


def take_over(flight: Flight) -> None:
    flight.one.station.core.pilot_takes(Mode.POSCTL)


def is_down(flight: Flight) -> bool:
    return not flight.one.station.core.armed


@pytest.mark.parametrize("death", [kill, hang])
def test_it_is_landed(death: Callable[[Flight], None], tmp_path: Path) -> None:
    flight = Flight(death, LANDED_S, at_s=IN_THE_CLIMB_S, until=is_down).fly(tmp_path / "run")
    assert flight.mode_since_s(Mode.LAND, flight.broken_s) < flight.broken_s + 2.5
    assert is_down(flight)


def test_it_is_landed_also_where_the_climb_was_just_broken_off(tmp_path: Path) -> None:
    """The wish to return is commanded after news of the present mode only: up to a second, in which PX4 climbs on to a HOLD."""
    flight = Flight(return_early, LANDED_S, at_s=IN_THE_CLIMB_S, until=is_down_after_a_death_before_it_returns)
    flight.fly(tmp_path / "run")
    assert flight.one.outcome is None, "it returned before it could be killed"
    assert flight.mode_since_s(Mode.LAND, flight.broken_s) < flight.broken_s + 4.0
    assert is_down(flight)


def test_it_is_left_to_a_pilot_who_flies_it(tmp_path: Path) -> None:
    flight = Flight(kill_under_a_pilot, 4.0, at_s=IN_THE_CLIMB_S).fly(tmp_path / "run")
    assert flight.one.station.core.mode is Mode.POSCTL
    assert not is_down(flight)


def test_where_the_link_is_lost_for_longer_than_the_app_waits_it_is_landed_when_the_link_is_back(tmp_path: Path) -> None:
    flight = Flight(lose_the_link, LINK_LOST_S + LANDED_S, at_s=IN_THE_CLIMB_S, until=is_down).fly(tmp_path / "run")
    ended = [event for event in flight.events("fault") if "link lost" in event["text"]]
    assert ended
    assert ended[0]["t_s"] < flight.broken_s + LINK_LOST_S
    assert flight.mode_since_s(Mode.LAND, flight.broken_s) < flight.broken_s + LINK_LOST_S + 2.5
    assert is_down(flight)


def test_a_pilot_who_took_over_while_the_link_was_lost_keeps_it(tmp_path: Path) -> None:
    flight = Flight(lose_the_link, LINK_LOST_S + 4.0, at_s=IN_THE_CLIMB_S, then=[(5.0, take_over)]).fly(tmp_path / "run")
    assert flight.one.outcome is not None
    assert flight.one.station.core.mode is Mode.POSCTL
    assert not is_down(flight)


@pytest.mark.parametrize("mode", Mode)
def test_only_what_the_climb_asked_for_is_ended(mode: Mode) -> None:
    assert (advice(ARMED, mode.custom_mode) is Advice.LAND) == (mode in (Mode.TAKEOFF, Mode.HOLD))
    assert advice(0, mode.custom_mode) is Advice.DISARMED


def have_telemetry_stuck(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.fault("telemetry", "stuck", duration_s=8.0)


def pause(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.one.station.core.pilot_takes(Mode.HOLD)


@pytest.mark.parametrize(("what", "phase"), [(have_telemetry_stuck, "pursue"), (pause, "released")])
def test_a_hold_below_the_height_is_a_pilots_only_if_the_vehicle_stands(
    what: Callable[[Flight], None], phase: str, tmp_path: Path
) -> None:
    """PX4 goes to HOLD when its climb has ended; a height that is stuck since (fault campaign, seed 119) is no pilot's choice."""
    flight = Flight(what, LANDED_S, at_s=IN_THE_CLIMB_S, until=lambda flight: flight.one.loop.phase == phase).fly(
        tmp_path / "run"
    )
    assert flight.one.loop.phase == phase
