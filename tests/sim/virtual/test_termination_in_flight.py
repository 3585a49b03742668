"""Missions that want a vehicle outside its contingency volume terminated: motors off, not under a pilot, what if refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.core.errors import FlightError
from flightapp.sim.autopilot_modes import Mode
from tests.sim.virtual.in_flight import MISSION, Flight

GIVEN_IN_S = 5.6
"""PX4's estimator gives in to a position that disagrees with it after 5 s; the guard confirms for 0.2 s."""


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    text = MISSION.read_text(encoding="utf-8")
    file = tmp_path / "terminating.toml"
    file.write_text(text.replace("height_max_m = 14.0", 'height_max_m = 14.0\noutside_action = "terminate"'), encoding="utf-8")
    return file


def leave_the_volume(flight: Flight) -> None:
    flight.fault("gps", "wrong", offset_m=30.0)


def leave_it_under_a_pilot(flight: Flight) -> None:
    flight.one.station.core.pilot_takes(Mode.POSCTL)
    leave_the_volume(flight)


def leave_it_with_an_autopilot_that_refuses(flight: Flight) -> None:
    async def refuse() -> None:
        raise FlightError("terminate refused: COMMAND_DENIED")

    flight.one.autopilot.terminate = refuse  # type: ignore[method-assign]
    leave_the_volume(flight)


def is_off(flight: Flight) -> bool:
    return not flight.one.station.core.armed


def test_the_motors_are_off_at_once(mission: Path, tmp_path: Path) -> None:
    flight = Flight(leave_the_volume, GIVEN_IN_S + 4.0, until=is_off, mission=mission).fly(tmp_path / "run")
    assert flight.fault_was_felt()
    states = [(event["data"]["state"], event["data"].get("condition")) for event in flight.events("failsafe")]
    assert ("TERMINATE", "fence_outside") in states
    assert is_off(flight)
    assert flight.now_s < flight.broken_s + GIVEN_IN_S + 3.0


def test_a_pilot_is_not_terminated(mission: Path, tmp_path: Path) -> None:
    flight = Flight(leave_it_under_a_pilot, GIVEN_IN_S + 2.0, mission=mission).fly(tmp_path / "run")
    assert flight.fault_was_felt()
    assert flight.one.station.core.armed
    assert not [t_s for t_s, _ in flight.one.autopilot.commanded if t_s > flight.broken_s]


def test_what_will_not_be_terminated_is_landed(mission: Path, tmp_path: Path) -> None:
    flight = Flight(
        leave_it_with_an_autopilot_that_refuses,
        GIVEN_IN_S + 15.0,
        until=lambda flight: flight.one.station.core.mode is Mode.LAND,
        mission=mission,
    ).fly(tmp_path / "run")
    assert any("COMMAND_DENIED" in event["text"] for event in flight.events("command_failed"))
    assert flight.one.station.core.mode is Mode.LAND
