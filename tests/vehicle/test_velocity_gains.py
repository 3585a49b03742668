"""The gains of the velocity loop: what the vehicle answers counts; the profile's where it says nothing useful."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from flightapp.config.profile import load_profile
from flightapp.control.tracker import make_tracker
from flightapp.core.errors import FlightError
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.velocity_loop import learn_velocity_gains
from flightapp.vehicle.autopilot import Autopilot
from flightapp.vehicle.velocity_gains import PLANAR, VERTICAL, VelocityGains, read_velocity_gains
from tests.sim.mock_process import mock_autopilot
from tests.sim.virtual_mock import VirtualMock
from tests.vehicle.test_px4 import px4

PROFILE = load_profile(Path(__file__).parents[2] / "profiles/sim.toml")
ASSUMED = VelocityGains(1.8, 4.0)


def test_the_mock_answers_with_what_its_loop_flies(tmp_path: Path) -> None:
    async def read(url: str) -> tuple[VelocityGains, str]:
        vehicle = px4(url)
        try:
            await vehicle.connect()
            return await read_velocity_gains(vehicle, ASSUMED)
        finally:
            vehicle.close()

    with mock_autopilot(tmp_path, parameters={PLANAR: 2.0}) as mock:
        gains, text = asyncio.run(read(mock.url))
    assert gains.planar_1_s == pytest.approx(2.0)
    assert gains.vertical_1_s == pytest.approx(2.0), "its reference loop has one gain for all axes"
    assert text == "velocity loop: MPC_XY_VEL_P_ACC 2, MPC_Z_VEL_P_ACC 2"


class Answering:
    """An autopilot that answers for parameters as given; an error is raised."""

    def __init__(self, answers: dict[str, float | FlightError | None]) -> None:
        self.answers = answers

    async def parameter(self, name: str, *, is_integer: bool) -> float | None:
        assert not is_integer
        answer = self.answers[name]
        if isinstance(answer, FlightError):
            raise answer
        return answer


@pytest.mark.parametrize("answer", [None, FlightError("parameter: BUSY"), math.nan, 0.0, -1.8, 1e6])
def test_where_the_vehicle_says_nothing_useful_the_profile_counts(answer: float | FlightError | None) -> None:
    autopilot = cast(Autopilot, Answering({PLANAR: answer, VERTICAL: 5.0}))
    gains, text = asyncio.run(read_velocity_gains(autopilot, ASSUMED))
    assert gains == VelocityGains(1.8, 5.0)
    assert "MPC_XY_VEL_P_ACC 1.8 as in the profile (" in text


def test_the_controller_learns_them_and_the_recording_says_so() -> None:
    events: list[dict[str, Any]] = []
    tracker = make_tracker(PROFILE)
    rooms = SimpleNamespace(
        tracker=tracker,
        profile=PROFILE,
        autopilot=Answering({PLANAR: 2.6, VERTICAL: None}),
        journal=SimpleNamespace(event=lambda level, name, text, **data: events.append({"name": name, "text": text, **data})),
    )
    asyncio.run(learn_velocity_gains(cast(Rooms, rooms)))
    assert tracker.loop == VelocityGains(2.6, 4.0)
    assert events[0]["planar_1_s"] == 2.6
    rooms.tracker = None
    asyncio.run(learn_velocity_gains(cast(Rooms, rooms)))
    assert len(events) == 1, "where the loop is alone nobody asks"


def test_the_mock_flies_by_the_gains_that_it_answers() -> None:
    speeds = {}
    for gain in (0.6, 1.8):
        mock = VirtualMock(parameters={PLANAR: gain, VERTICAL: gain})
        mock.take_off()
        mock.fly_offboard(2.0, down=0.0)
        mock.run(1.0)
        speeds[gain] = mock.core.vehicle.velocity_ned_m_s[0]
    assert speeds[0.6] < 1.1 < 1.4 < speeds[1.8]
