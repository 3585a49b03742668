"""A vehicle process that dies before OFFBOARD: nothing of PX4's own ends a climb, so the deadman has the vehicle landed."""

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


def kill(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.one.kill()


def hang(flight: Flight) -> None:
    assert flight.one.loop.phase == "takeoff"
    flight.one.hang()


def kill_under_a_pilot(flight: Flight) -> None:
    flight.one.station.core.pilot_takes(Mode.POSCTL)
    kill(flight)


def is_down(flight: Flight) -> bool:
    return not flight.one.station.core.armed


@pytest.mark.parametrize("death", [kill, hang])
def test_it_is_landed(death: Callable[[Flight], None], tmp_path: Path) -> None:
    flight = Flight(death, LANDED_S, at_s=IN_THE_CLIMB_S, until=is_down).fly(tmp_path / "run")
    assert flight.mode_since_s(Mode.LAND, flight.broken_s) < flight.broken_s + 2.5
    assert is_down(flight)


def test_it_is_left_to_a_pilot_who_flies_it(tmp_path: Path) -> None:
    flight = Flight(kill_under_a_pilot, 4.0, at_s=IN_THE_CLIMB_S).fly(tmp_path / "run")
    assert flight.one.station.core.mode is Mode.POSCTL
    assert not is_down(flight)


@pytest.mark.parametrize("mode", Mode)
def test_only_what_the_climb_asked_for_is_ended(mode: Mode) -> None:
    assert (advice(ARMED, mode.custom_mode) is Advice.LAND) == (mode in (Mode.TAKEOFF, Mode.HOLD))
    assert advice(0, mode.custom_mode) is Advice.DISARMED
