"""The pilot takes over at any time, in any mode, whatever the app is doing: seen at once, never fought."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.virtual.autopilot import STARTING_S
from tests.sim.virtual.in_flight import Flight

SEEN_WITHIN_S = 0.2
HEARTBEAT_S = 1.0
EARLIEST_S, LATEST_S = 2.4, 11.0
"""Mission time: from just after take-off began to well into hold, return or landing."""
COMMAND_S = 6.9
TAKEN_MODES = (Mode.POSCTL, Mode.ALTCTL, Mode.MANUAL)


@dataclass(frozen=True, slots=True)
class Takeover:
    """When, into which mode, after which operator command, and whether the autopilot tells changes at once."""

    at_s: float
    mode: Mode
    command: str
    tells_changes: bool


def drawn(seed: int) -> Takeover:
    chance = random.Random(f"takeover {seed}")
    command = chance.choice(("", "hold", "rtl", "land"))
    return Takeover(chance.uniform(EARLIEST_S, LATEST_S), chance.choice(TAKEN_MODES), command, chance.random() < 0.6)


BEFORE_OFFBOARD = Takeover(4.9, Mode.POSCTL, "", tells_changes=False)
"""The setpoints flow already, OFFBOARD is about to be commanded, and the next heartbeat is not due yet."""
TAKEOVERS = (BEFORE_OFFBOARD, *map(drawn, range(7)))


@pytest.mark.parametrize("takeover", TAKEOVERS, ids=str)
def test_a_takeover_is_seen_and_never_fought(takeover: Takeover, tmp_path: Path) -> None:
    flight = Flight(lambda flight: prepare(flight, takeover), takeover.at_s + 2.0, at_s=0.0)
    flight.then = tuple(sorted(((COMMAND_S, command_of(takeover)), (takeover.at_s, taking(takeover))), key=lambda item: item[0]))
    flight.fly(tmp_path)
    assert flight.one.station.core.piloted
    taken_s = flight.mode_since_s(takeover.mode, flight.broken_s)
    seen_s = SEEN_WITHIN_S if takeover.tells_changes else HEARTBEAT_S + SEEN_WITHIN_S
    told = [event for event in flight.events("failsafe") if event["data"]["state"] == "PILOT"]
    assert [event["data"]["condition"] for event in told] == ["pilot_has_control"]
    assert math.isfinite(taken_s)
    assert told[0]["t_s"] <= taken_s + seen_s
    assert [what for t_s, what in flight.one.autopilot.commanded if t_s > taken_s] == []
    assert [t_s for t_s, _ in flight.one.autopilot.sent if t_s > told[0]["t_s"]] == []
    heard = flight.one.station.core.setpoint
    assert heard is None or heard.t_s <= max(told[0]["t_s"], repeated_until_s(flight)) - flight.broken_s + 0.01
    assert flight.moments[-1].mode is takeover.mode


def repeated_until_s(flight: Flight) -> float:
    """MAVSDK repeats the last setpoint by itself; whatever mode is reported, it does so for its first seconds of OFFBOARD."""
    started_s = [t_s for t_s, what in flight.one.autopilot.commanded if what == "OFFBOARD"]
    return started_s[-1] + STARTING_S + HEARTBEAT_S if started_s else -math.inf


def prepare(flight: Flight, takeover: Takeover) -> None:
    flight.one.station.core.heartbeat_on_change = takeover.tells_changes


def command_of(takeover: Takeover) -> Callable[[Flight], None]:
    return lambda flight: flight.command(takeover.command) if takeover.command else None


def taking(takeover: Takeover) -> Callable[[Flight], None]:
    return lambda flight: flight.one.station.core.pilot_takes(takeover.mode)
